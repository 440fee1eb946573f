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
