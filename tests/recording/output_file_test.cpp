#include "recording/output_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/error.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

TEST(OutputFile, AppearsUnderItsNameWithAllItsBytesWhenCommitted) {
  TempFolder folder;
  OutputFile file(folder / "a.txt");
  file.write("one ");
  file.write("two");
  EXPECT_FALSE(std::filesystem::exists(folder / "a.txt"));
  EXPECT_TRUE(std::filesystem::exists(folder / "a.txt.part"));
  file.commit();
  EXPECT_EQ(bytes_of(folder / "a.txt"), "one two");
  EXPECT_FALSE(std::filesystem::exists(folder / "a.txt.part"));
}

TEST(OutputFile, LeavesNothingBehindWhenItIsNotCommitted) {
  TempFolder folder;
  { OutputFile(folder / "a.txt").write("half"); }
  EXPECT_TRUE(std::filesystem::is_empty(folder / ""));
}

TEST(OutputFile, KeepsTheOldFileUntilTheNewOneIsWhole) {
  TempFolder folder;
  const auto path = folder.write("a.txt", "old");
  { OutputFile(path).write("half"); }
  EXPECT_EQ(bytes_of(path), "old");
  OutputFile file(path);
  file.write("new");
  file.commit();
  EXPECT_EQ(bytes_of(path), "new");
}

TEST(OutputFile, NamesTheFileThatCannotBeCreated) {
  TempFolder folder;
  try {
    OutputFile file(folder / "missing/a.txt");
    FAIL() << "no folder, but a file";
  } catch (const RunError& error) {
    EXPECT_NE(std::string(error.what()).find("missing/a.txt"), std::string::npos);
  }
}

TEST(OutputFile, FailsWhenTheNameIsTakenByAFolder) {
  TempFolder folder;
  std::filesystem::create_directory(folder / "a.txt");
  OutputFile file(folder / "a.txt");
  file.write("x");
  EXPECT_THROW(file.commit(), RunError);
}

TEST(OutputFile, FailsWhenTheDiskTakesNoMoreBytes) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full: a full disk is not tried";
  TempFolder folder;
  std::filesystem::create_symlink("/dev/full", folder / "a.txt.part");
  OutputFile file(folder / "a.txt");
  file.write("x");
  EXPECT_THROW(file.commit(), RunError);
  EXPECT_FALSE(std::filesystem::exists(folder / "a.txt"));
}

TEST(OutputFile, KeepsTheOrderOfALongFileAndOfWhatIsOverwrittenInIt) {
  const TempFolder folder;
  std::string text;
  for (int i = 0; i < 200'000; ++i) text += std::to_string(i) + "\n";  // many blocks
  {
    OutputFile file(folder / "a.txt");
    file.write(std::string_view(text).substr(0, 300'001));
    file.overwrite(70'000, std::as_bytes(std::span("####", 4)));
    for (std::size_t at = 300'001; at < text.size(); at += 1'003)
      file.write(std::string_view(text).substr(at, 1'003));
    file.commit();
  }
  text.replace(70'000, 4, "####");
  EXPECT_EQ(bytes_of(folder / "a.txt"), text);
}

TEST(OutputFile, KeepsWhatWasSyncedWithoutCommit) {
  const TempFolder folder;
  const std::string text(1'000'000, 'x');
  {
    OutputFile file(folder / "a.txt");
    file.write(text);
    file.sync();
    EXPECT_EQ(bytes_of(folder / "a.txt.part"), text);
  }
  EXPECT_EQ(bytes_of(folder / "a.txt.part"), text);
  EXPECT_FALSE(std::filesystem::exists(folder / "a.txt"));
}

TEST(OutputFile, ReportsAFullDiskWhileALongFileIsWritten) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full: a full disk is not tried";
  const TempFolder folder;
  std::filesystem::create_symlink("/dev/full", folder / "a.txt.part");
  OutputFile file(folder / "a.txt");
  const std::string block(1'000'000, 'x');
  EXPECT_THROW(
      {
        for (int i = 0; i < 100; ++i) file.write(block);
      },
      DiskFull);
  EXPECT_THROW(file.commit(), DiskFull);
}

TEST(CheckOutputs, RejectsFoldersFilesThatExistAndTheInputsUnderAnyName) {
  namespace fs = std::filesystem;
  const TempFolder folder;
  const std::vector<fs::path> inputs = {folder.write("in", "1")};
  folder.write("old", "2");
  fs::create_hard_link(folder / "in", folder / "hard");
  fs::create_symlink(folder / "in", folder / "soft");
  fs::create_directory(folder / "folder");
  fs::create_hard_link(folder / "in", folder / "new.part");
  const auto message = [&](const char* output, bool force) -> std::string {
    const std::vector<fs::path> outputs = {folder / "first", folder / output};
    try {
      check_outputs(outputs, inputs, force);
    } catch (const InputError& error) {
      return error.what();
    }
    return "fine";
  };
  EXPECT_EQ(message("none", false), "fine");
  EXPECT_EQ(message("old", true), "fine");
  EXPECT_THAT(message("old", false), testing::HasSubstr("a file that exists"));
  EXPECT_THAT(message("folder", true), testing::HasSubstr("a folder"));
  for (const char* name : {"in", "hard", "soft", "new"}) {
    EXPECT_THAT(message(name, true), testing::HasSubstr("the file that is read")) << name;
  }
}

}  // namespace
}  // namespace saccade
