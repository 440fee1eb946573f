// The files that a run reads, and their digests.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "config/input_files.h"
#include "config/mentioned_files.h"
#include "external/external_rows.h"
#include "tests/config/built_in.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;
using testing::Contains;
using testing::IsEmpty;
using testing::Not;
using testing::UnorderedElementsAre;

class InputFilesOf : public testing::Test {
 protected:
  [[nodiscard]] std::vector<std::string> mentioned(const std::string& name, const std::string& folder = "") {
    std::vector<std::string> names;
    for (const std::string& path :
         mentioned_files(folder_ / name, folder.empty() ? fs::path() : folder_ / folder))
      names.push_back(fs::path(path).lexically_relative(fs::path(folder_ / name).parent_path()).string());
    return names;
  }
  void make_folder(const std::string& name) { fs::create_directories(folder_ / name); }
  [[nodiscard]] Scenario scenario(const std::string& rest, const std::vector<std::string>& sets = {}) {
    Registry registry = built_in();
    add_external_detectors(registry.detectors);
    add_external_controllers(registry.controllers);
    return read_scenario(folder_.write("scene.yaml", "name: a\nrun: {duration_s: 1}\n" + rest), sets,
                         std::nullopt, registry);
  }
  /// By the name of the file.
  [[nodiscard]] static std::string digest_in(const std::vector<FileDigest>& files, const std::string& name) {
    const auto at = std::ranges::find_if(
        files, [&](const FileDigest& file) { return fs::path(file.path).filename() == name; });
    return at == files.end() ? "not listed" : at->digest;
  }

  TempFolder folder_;
};

TEST_F(InputFilesOf, APythonFileAreTheModulesThatItImportsAndTheFilesThatItNames) {
  folder_.write("detector.py",
                "import numpy as np\nimport helper\nfrom package.part import thing\n"
                "W = np.load(f'{HERE}/weights.npz')\nT = open(\"a table.csv\")\n"
                "L = '/etc/passwd'\nU = 'unknown.bin'\n");
  folder_.write("helper.py", "NAME = 'constants.json'\n");
  folder_.write("constants.json", "{}");
  folder_.write("weights.npz", "bytes");
  folder_.write("a table.csv", "1");
  folder_.write("other.py", "");
  make_folder("package/deep");
  folder_.write("package/part.py", "");
  folder_.write("package/deep/inner.py", "");
  EXPECT_THAT(mentioned("detector.py"),
              UnorderedElementsAre("helper.py", "constants.json", "weights.npz", "a table.csv",
                                   "package/part.py", "package/deep/inner.py"));
}

TEST_F(InputFilesOf, AScriptAreSoughtBesideItAndInTheWorkingDirectory) {
  make_folder("work");
  folder_.write("work/limits.txt", "1");
  folder_.write("beside.txt", "1");
  folder_.write("script", "#!/bin/sh\nread x < limits.txt\n. $HERE/beside.txt\n");
  EXPECT_THAT(mentioned("script", "work"), UnorderedElementsAre("work/limits.txt", "beside.txt"));
}

TEST_F(InputFilesOf, AModelAreItsPartsAlsoInTheFoldersThatItNames) {
  make_folder("meshes");
  folder_.write("room.xml",
                "<mujoco><compiler meshdir=\"meshes\"/><include file=\"part.xml\"/>"
                "<asset><mesh file=\"chair.obj\"/></asset></mujoco>");
  folder_.write("part.xml", "<mujocoinclude><texture file='wood.png'/></mujocoinclude>");
  folder_.write("wood.png", "png");
  folder_.write("meshes/chair.obj", "v 0 0 0");
  EXPECT_THAT(mentioned("room.xml"), UnorderedElementsAre("part.xml", "wood.png", "meshes/chair.obj"));
}

TEST_F(InputFilesOf, AProgramThatNamesItselfOrIsBinaryAreNone) {
  folder_.write("loop.py", "import loop\nNAME = 'loop.py'\n");
  folder_.write("binary", std::string("weights.npz\0", 12));
  folder_.write("weights.npz", "bytes");
  EXPECT_THAT(mentioned("loop.py"), IsEmpty());
  EXPECT_THAT(mentioned("binary"), IsEmpty());
}

TEST_F(InputFilesOf, AScenarioHaveAnotherDigestOnceTheirContentsChange) {
  folder_.write("motion.csv", "t_s,x_m,y_m,z_m\n0,-0.5,0,0.3\n1,-0.5,0.1,0.3\n");
  folder_.write("mine.py", "class Mine: pass\n");
  folder_.write("gains.txt", "1");
  folder_.write("control.sh", "#!/bin/sh\n");
  const std::string yaml =
      "ball: {trajectory: {kind: csv, file: motion.csv}}\n"
      "detectors: {mine: {python: mine.py:Mine}}\n"
      "gaze: {detector: mine, controller: command, command: {command: ./control.sh, arguments: -k "
      "gains=gains.txt}}\n";
  const Scenario read = scenario(yaml);
  const std::vector<FileDigest> before = InputFiles().of(read);
  EXPECT_EQ(InputFiles().of(read), before);
  for (const char* name : {"motion.csv", "mine.py", "gains.txt", "control.sh"}) {
    const std::string bytes = bytes_of(folder_ / name);
    folder_.write(name, bytes + "\n");
    const std::vector<FileDigest> after = InputFiles().of(read);
    EXPECT_EQ(after.size(), 4u);
    EXPECT_NE(digest_in(before, name), "not listed") << name;
    EXPECT_NE(digest_in(after, name), digest_in(before, name)) << name;
    folder_.write(name, bytes);
  }
  EXPECT_EQ(InputFiles().of(read), before) << "the same contents again";
}

TEST_F(InputFilesOf, AScenarioWithoutFilesAreNone) {
  EXPECT_THAT(InputFiles().of(scenario("ball: {trajectory: {kind: hold, points_m: [[-0.5, 0, 0.347]]}}\n"
                                       "detectors: {best: {}}\ngaze: {detector: best}\n")),
              IsEmpty());
}

TEST_F(InputFilesOf, ACommandInPathAreThatProgramAndItsArguments) {
  folder_.write("detector.pl", "print 1;\n");
  const std::string yaml =
      "ball: {trajectory: {kind: hold, points_m: [[-0.5, 0, 0.347]]}}\n"
      "detectors: {mine: {command: sh, arguments: detector.pl}}\ngaze: {detector: mine}\n";
  const Scenario read = scenario(yaml);
  EXPECT_THAT(resolved_scenario(read), testing::HasSubstr("command: sh\n"));
  const std::vector<FileDigest> files = InputFiles().of(read);
  EXPECT_NE(digest_in(files, "sh"), "not listed");
  EXPECT_NE(digest_in(files, "detector.pl"), "not listed");
  folder_.write("sh", "#!/bin/sh\n");
  EXPECT_THAT(resolved_scenario(scenario(yaml)), testing::HasSubstr((folder_ / "sh").string()))
      << "a file beside the scenario comes first";
}

}  // namespace
}  // namespace saccade
