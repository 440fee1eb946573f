// Detectors outside of this program that a user adds in the window.
#include "apps/view/own_detector.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/error.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

struct FileConfig {
  std::string file;
};
void describe(FieldVisitor& v, FileConfig& config) { v.path("python", config.file, "a file"); }
struct ProgramConfig {
  std::string file;
};
void describe(FieldVisitor& v, ProgramConfig& config) { v.path("command", config.file, "a program"); }

DetectorRegistry registry() {
  DetectorRegistry registry;
  DetectorRow python = detector_row("python", "a class", FileConfig{}, [](const FileConfig&, const Camera&) {
    return std::unique_ptr<Detector>();
  });
  python.selecting_key = "python";
  registry.add(python);
  DetectorRow command =
      detector_row("command", "a program", ProgramConfig{},
                   [](const ProgramConfig&, const Camera&) { return std::unique_ptr<Detector>(); });
  command.selecting_key = "command";
  registry.add(command);
  return registry;
}

TEST(OwnDetector, IsAClassInPythonOrAProgramWithTheNameOfEither) {
  const TempFolder folder;
  const std::string file = folder.write("my file.py", "").string();
  const ViewDetector in_python = own_detector(registry(), file + ":RingMeanShift", {});
  EXPECT_EQ(in_python.name, "RingMeanShift");
  EXPECT_TRUE(in_python.enabled);
  EXPECT_EQ(in_python.config.preset(), "python");
  EXPECT_EQ(in_python.config.get<FileConfig>().file, file + ":RingMeanShift");
  const std::string program = folder.write("ring shift.sh", "").string();
  const ViewDetector in_shell = own_detector(registry(), program, {});
  EXPECT_EQ(in_shell.name, "ringshift");
  EXPECT_EQ(in_shell.config.get<ProgramConfig>().file, program);
}

TEST(OwnDetector, GetsANumberWhereItsNameIsTaken) {
  const TempFolder folder;
  const std::string file = folder.write("a.py", "").string() + ":Mine";
  std::vector<ViewDetector> others = {own_detector(registry(), file, {})};
  others.push_back(own_detector(registry(), file, others));
  EXPECT_EQ(others.back().name, "Mine_2");
  EXPECT_EQ(own_detector(registry(), file, others).name, "Mine_3");
}

TEST(OwnDetector, AFileThatDoesNotExistIsRejected) {
  EXPECT_THAT([] { (void)own_detector(registry(), "/absent.py:Mine", {}); },
              ThrowsMessage<InputError>(HasSubstr("found /absent.py, expected FILE.py:CLASS")));
  EXPECT_THROW((void)own_detector(registry(), "/absent", {}), InputError);
}

}  // namespace
}  // namespace saccade
