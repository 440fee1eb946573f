#include "session/failure_log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "head/icub_cameras.h"
#include "session/progress.h"
#include "session/run_recorder.h"
#include "session/session.h"
#include "tests/loop/packet_robot.h"

namespace saccade {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Pair;

/// A detector that ends at 3 ms.
class EndingDetector final : public Detector {
 public:
  void process(std::span<const Event>, const CameraMotion*) override {}
  void advance_to(std::int64_t now_us, const CameraMotion*) override { now_us_ = now_us; }
  [[nodiscard]] Estimate estimate() override { return {}; }
  [[nodiscard]] double threshold() const override { return 0.0; }
  [[nodiscard]] RejectedEvents rejected() const override { return {}; }
  [[nodiscard]] std::string_view failure() const override { return now_us_ >= 3000 ? "it has ended" : ""; }

 private:
  std::int64_t now_us_ = 0;
};

TEST(FailureLog, ReportsOnceWhenADetectorEnds) {
  PacketRobot robot({});
  std::vector<LoopDetector> detectors;
  detectors.push_back({"mine", std::make_unique<EndingDetector>()});
  detectors.push_back({"other", std::make_unique<NewestEventDetector>()});
  Loop loop(robot, MountedCamera{icub_left_2016, {}}, std::move(detectors), std::nullopt);
  std::vector<std::string> lines;
  FailureLog log(loop, [&](std::int64_t t_us, const std::string& what, const std::string& why) {
    lines.push_back(std::to_string(t_us) + " " + what + ": " + why);
  });
  Session session(robot, loop);
  session.add_observer(log);
  session.run(1000, 6000);
  EXPECT_THAT(lines, ElementsAre("3000 detector mine: it has ended"));
}

TEST(Progress, HasALineEachTenthInALog) {
  testing::internal::CaptureStderr();
  {
    Progress progress(50.0);
    for (int i = 0; i <= 50; ++i) progress.show(i, [&] { return "at " + std::to_string(i); });
    progress.print_line("between");
  }
  const std::string text = testing::internal::GetCapturedStderr();
  EXPECT_EQ(std::ranges::count(text, '\n'), 12) << text;
  EXPECT_THAT(text, HasSubstr("at 25\n"));
  EXPECT_THAT(text, HasSubstr("between\n"));
}

TEST(SettingsOf, AreTheOverridesThatChangeWhatIsScored) {
  EXPECT_THAT(settings_of({"lab.clutter=textured", "output.video=true", "run.duration_s=2", "seed=3",
                           "expect.a=1", "lab.clutter=rectilinear", "best.threshold=0.4"}),
              ElementsAre(Pair("best.threshold", "0.4"), Pair("lab.clutter", "rectilinear")));
}

}  // namespace
}  // namespace saccade
