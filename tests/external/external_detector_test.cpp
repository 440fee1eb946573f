// Detectors in programs of their own: the protocol, and what happens when a program breaks it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <numbers>

#include "core/detectors/built_in_detectors.h"
#include "core/error.h"
#include "external/external_detector.h"
#include "external/external_rows.h"
#include "external/line_process.h"
#include "external/line_text.h"
#include "head/icub_cameras.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

const std::string examples = SACCADE_SOURCE_DIR "/examples/external/";

/// 10 events per ms on a circle of 12 px that stays where it is.
std::vector<Event> circle_events(std::int64_t from_us, std::int64_t until_us) {
  std::vector<Event> events;
  for (std::int64_t t_us = from_us + 100; t_us <= until_us; t_us += 100) {
    const double angle_rad =
        2.0 * std::numbers::pi * std::fmod(0.618034 * static_cast<double>(t_us / 100), 1.0);
    events.push_back({t_us, static_cast<std::uint16_t>(std::lround(60 + 12 * std::cos(angle_rad))),
                      static_cast<std::uint16_t>(std::lround(50 + 12 * std::sin(angle_rad))), t_us % 200 == 0,
                      0});
  }
  return events;
}

/// Ticks of 1 ms up to `until_us`; the estimate of the last one.
Estimate run(Detector& detector, std::int64_t until_us) {
  Estimate estimate;
  for (std::int64_t t_us = 1000; t_us <= until_us; t_us += 1000) {
    const std::vector<Event> events = circle_events(t_us - 1000, t_us);
    detector.process(events, nullptr);
    detector.advance_to(t_us, nullptr);
    estimate = detector.estimate();
  }
  return estimate;
}

std::unique_ptr<Detector> make(const std::string& kind, const std::string& path) {
  if (kind == "python") {
    PythonConfig config;
    config.python = path;
    return std::make_unique<ExternalDetector>(path, program_call(config), config.limits, icub_left_2016);
  }
  CommandConfig config;
  config.command = path;
  config.limits.answer_limit_s = 0.3;
  config.limits.start_limit_s = 5.0;
  return std::make_unique<ExternalDetector>("mine", program_call(config), config.limits, icub_left_2016);
}

/// A program in the shell: it reads both lines of the start and says ready; `ticks` is the rest of it.
class ShellProgram {
 public:
  explicit ShellProgram(const std::string& ticks, const std::string& ready = "echo ready 0.5")
      : path_((folder_ / "mine").string()) {
    std::ofstream(path_) << "#!/bin/sh\nread a; read b\n" << ready << "\n" << ticks << "\n";
    ::chmod(path_.c_str(), 0755);
  }
  [[nodiscard]] std::unique_ptr<Detector> start() const { return make("command", path_); }

 private:
  TempFolder folder_;
  std::string path_;
};

// Reads a tick and its events.
const std::string read_tick =
    "read tick t count; i=0; while [ $i -lt $count ]; do read event; i=$((i+1)); done; ";
const std::string loop_of =
    "while read tick t count; do i=0; while [ $i -lt $count ]; do read event; i=$((i+1)); done; ";

TEST(ExternalDetector, InPythonFindsACircle) {
  const auto detector = make("python", examples + "ring_mean_shift.py:RingMeanShift");
  const Estimate estimate = run(*detector, 80'000);
  EXPECT_THAT(detector->failure(), IsEmpty());
  EXPECT_EQ(detector->threshold(), 0.5);
  ASSERT_TRUE(estimate.valid);
  // Pixels are rounded: half a pixel each.
  EXPECT_NEAR(estimate.circle.x_px, 60, 0.5);
  EXPECT_NEAR(estimate.circle.y_px, 50, 0.5);
  EXPECT_NEAR(estimate.circle.r_px, 12, 0.5);
  EXPECT_GT(estimate.score, 0.9);
}

TEST(ExternalDetector, InCAnswersAsTheOneInPython) {
  const auto in_python = make("python", examples + "ring_mean_shift.py:RingMeanShift");
  const auto in_c = make("command", SACCADE_RING_MEAN_SHIFT);
  for (std::int64_t t_us = 1000; t_us <= 80'000; t_us += 1000) {
    const std::vector<Event> events = circle_events(t_us - 1000, t_us);
    Estimate estimates[2];
    for (int i = 0; i < 2; ++i) {
      Detector& detector = i == 0 ? *in_python : *in_c;
      detector.process(events, nullptr);
      detector.advance_to(t_us, nullptr);
      estimates[i] = detector.estimate();
    }
    ASSERT_EQ(estimates[0].valid, estimates[1].valid) << t_us;
    // The same arithmetic, summed in another order.
    EXPECT_NEAR(estimates[0].circle.x_px, estimates[1].circle.x_px, 1e-6) << t_us;
    EXPECT_NEAR(estimates[0].circle.r_px, estimates[1].circle.r_px, 1e-6) << t_us;
    EXPECT_NEAR(estimates[0].score, estimates[1].score, 1e-6) << t_us;
  }
}

TEST(ExternalDetector, GetsEveryEventOnceAndTheTime) {
  const ShellProgram program(loop_of + "echo circle $count $(($t / 1000)) 1 0.9; done");
  const auto detector = program.start();
  detector->process(circle_events(0, 500), nullptr);
  detector->process(circle_events(500, 1000), nullptr);
  detector->advance_to(1'000, nullptr);
  EXPECT_EQ(detector->estimate().circle.x_px, 10.0);
  EXPECT_EQ(detector->estimate().circle.x_px, 10.0) << "nothing new: the same estimate";
  detector->advance_to(2'000, nullptr);
  EXPECT_EQ(detector->estimate().circle.x_px, 0.0);
  EXPECT_EQ(detector->estimate().circle.y_px, 2.0);
  EXPECT_FALSE(detector->estimate().held);
}

TEST(ExternalDetector, GetsNoEventOutsideTheImageOrBackInTime) {
  const ShellProgram program(loop_of + "echo circle $count 1 1 0.9; done");
  const auto detector = program.start();
  detector->process(std::vector<Event>{{100, 5, 5, true, 0}, {50, 5, 5, true, 0}, {200, 500, 5, true, 0}},
                    nullptr);
  EXPECT_EQ(detector->estimate().circle.x_px, 1.0);
  EXPECT_EQ(detector->rejected().back_in_time, 1);
  EXPECT_EQ(detector->rejected().outside_image, 1);
}

TEST(ExternalDetector, GetsTheMotionOfTheCameraWhereItAsksForIt) {
  const ShellProgram program(
      "while read tick t count; do read word a b c d rest; echo circle 1 1 1 0.9; echo $word $a $d >> "
      "$0.log; done",
      "echo ready 0.5 motion");
  const auto detector = program.start();
  CameraMotion motion;
  motion.root_from_camera.translation().x() = 0.25;
  detector->advance_to(1'000, &motion);
  EXPECT_TRUE(detector->estimate().valid);
  detector->advance_to(2'000, nullptr);
  EXPECT_TRUE(detector->estimate().valid);
}

struct Breach {
  const char* name;
  std::string ticks;
  const char* expected;
};
void PrintTo(const Breach& breach, std::ostream* out) { *out << breach.name; }

class BrokenProgram : public testing::TestWithParam<Breach> {};

TEST_P(BrokenProgram, EndsTheDetectorAndIsReported) {
  const ShellProgram program(read_tick + "echo circle 1 2 3 0.9\n" + GetParam().ticks);
  const auto detector = program.start();
  detector->process(circle_events(0, 1000), nullptr);
  detector->advance_to(1'000, nullptr);
  EXPECT_TRUE(detector->estimate().valid);
  for (std::int64_t t_us = 2'000; t_us <= 5'000; t_us += 1000) {
    detector->process(circle_events(t_us - 1000, t_us), nullptr);
    detector->advance_to(t_us, nullptr);
    EXPECT_FALSE(detector->estimate().valid);
  }
  EXPECT_THAT(std::string(detector->failure()), HasSubstr(GetParam().expected));
  EXPECT_THAT(std::string(detector->failure()), HasSubstr("0.002 s"));
  EXPECT_EQ(detector->threshold(), 0.5);
}

INSTANTIATE_TEST_SUITE_P(
    ExternalDetector, BrokenProgram,
    testing::Values(Breach{"ends", "exit 3", "with status 3"},
                    Breach{"saysWhy", read_tick + "echo failed no more of it; exit 3",
                           "mine failed at 0.002 s: no more of it"},
                    Breach{"crashes", "kill -SEGV $$", "by signal 11"},
                    Breach{"closesItsOutput", "exec 0<&- 1>&-; exec sleep 60",
                           "mine closed its output at 0.002 s"},
                    Breach{"hangs", "exec sleep 60", "no answer at 0.002 s within 300 ms"},
                    Breach{"neverReads", read_tick + "exec sleep 60", "no answer"},
                    Breach{"nan", read_tick + "echo circle nan 1 2 0.5", "`circle nan 1 2 0.5`"},
                    Breach{"infinite", read_tick + "echo circle 1 1 2 inf", "expected `none` or `circle"},
                    Breach{"noRadius", read_tick + "echo circle 1 1 0 0.5", "expected `none`"},
                    Breach{"tooFewNumbers", read_tick + "echo circle 1 2 3", "`circle 1 2 3`"},
                    Breach{"tooManyWords", read_tick + "echo none at all", "`none at all`"},
                    Breach{"noise", read_tick + "printf 'a\\001b\\n'", "`a?b`"},
                    Breach{"emptyLine", read_tick + "echo", "``"},
                    Breach{"endlessLine", read_tick + "head -c 100000 /dev/zero", "more than 4096 bytes"}),
    [](const auto& tried) { return tried.param.name; });

TEST(ExternalDetector, TwoAnswersToOneTickEndIt) {
  const ShellProgram program(read_tick + "printf 'none\\nnone\\n'; sleep 5");  // both lines in one write
  const auto detector = program.start();
  detector->advance_to(1'000, nullptr);
  (void)detector->estimate();
  for (std::int64_t t_us = 2'000; t_us <= 3'000; t_us += 1'000) {
    detector->advance_to(t_us, nullptr);
    (void)detector->estimate();
  }
  EXPECT_FALSE(detector->failure().empty());
}

// The tick of a robot waits here, and freeing the memory of a large program takes longer than the head may be without ticks.
TEST(LineProcess, DoesNotWaitForTheEndOfAProgramThatItKills) {
  LineProcess hanging(ProgramCall{{"sleep", "60"}}, std::chrono::seconds(10));
  EXPECT_EQ(hanging.end(std::chrono::milliseconds(0)), "") << "it says how the program ended: it has waited";
}

TEST(ExternalDetector, NamesAnInstantToTheMicrosecond) {
  EXPECT_EQ(moment_of(2'633'999), "at 2.633999 s");  // 2633999 * 1e-6 has 17 digits
  EXPECT_EQ(moment_of(0), "at 0 s");
}

TEST(ExternalDetector, ThatDoesNotStartIsAnError) {
  EXPECT_THROW(make("command", "/no/such/program"), InputError);
  EXPECT_THROW(make("python", examples + "absent.py:Mine"), InputError);
  EXPECT_THROW(make("python", examples + "ring_mean_shift.py"), InputError);
  EXPECT_THROW(make("python", examples + "ring_mean_shift.py:NoSuchClass"), RunError);
  EXPECT_THROW(static_cast<void>(ShellProgram("", "exit 4").start()), RunError);
  EXPECT_THROW(static_cast<void>(ShellProgram("sleep 1", "echo hello").start()), RunError);
  EXPECT_THROW(static_cast<void>(ShellProgram("sleep 1", "echo ready nan").start()), RunError);
}

TEST(ExternalDetector, EndsItsProgramWithItself) {
  TempFolder folder;
  const std::string marker = (folder / "marker").string();
  {
    const ShellProgram program(loop_of + "echo none; done; echo $? > " + marker);
    const auto detector = program.start();
    detector->advance_to(1'000, nullptr);
    EXPECT_FALSE(detector->estimate().valid);
  }
  EXPECT_TRUE(std::filesystem::exists(marker)) << "the end of its standard input ended the loop";
}

TEST(ExternalDetector, IsARowOfTheRegistryWithItsKeys) {
  DetectorRegistry registry = built_in_detectors();
  add_external_detectors(registry);
  for (const char* name : {"python", "command", "socket"}) {
    EXPECT_EQ(registry.rows().find(name)->selecting_key, name);
    EXPECT_THROW(static_cast<void>(make_detector(registry.config(name), icub_left_2016)), InputError)
        << "its file is not given";
  }
}

TEST(ExternalAnswer, IsReadExactly) {
  const auto estimate = parse_estimate("circle 1.5 -2 3e1 0.25 held");
  ASSERT_TRUE(estimate);
  EXPECT_EQ(estimate->circle.x_px, 1.5);
  EXPECT_EQ(estimate->circle.y_px, -2.0);
  EXPECT_EQ(estimate->circle.r_px, 30.0);
  EXPECT_EQ(estimate->score, 0.25);
  EXPECT_TRUE(estimate->held);
  EXPECT_FALSE(parse_estimate("none")->valid);
  EXPECT_EQ(estimate->covariance_px2, Eigen::Matrix3d::Zero());
  Eigen::Matrix3d covariance;
  covariance << 4, 0.5, -1, 0.5, 9, 0.25, -1, 0.25, 2;
  for (const char* line :
       {"circle 1 1 1 1 covariance 4 0.5 -1 9 0.25 2", "circle 1 1 1 1 held covariance 4 0.5 -1 9 0.25 2"}) {
    ASSERT_TRUE(parse_estimate(line)) << line;
    EXPECT_EQ(parse_estimate(line)->covariance_px2, covariance) << line;
  }
  for (const char* line :
       {"", "Circle 1 1 1 1", "circle 1 1 1 1 hold", "circle 1 1 -1 1", "circle 1 1 1 1 held x",
        "circle 1 1 1 1 covariance", "circle 1 1 1 1 covariance 1 0 0 1 0",
        "circle 1 1 1 1 covariance 1 0 0 1 0 1 1", "circle 1 1 1 1 covariance -1 0 0 1 0 1",
        "circle 1 1 1 1 covariance 1 0 0 1 0 1 held"})
    EXPECT_FALSE(parse_estimate(line)) << line;
  EXPECT_TRUE(parse_ready("ready 0.5 motion binary")->binary);
  for (const char* line : {"ready", "ready x", "ready 1 text", "ready inf"})
    EXPECT_FALSE(parse_ready(line)) << line;
}

}  // namespace
}  // namespace saccade
