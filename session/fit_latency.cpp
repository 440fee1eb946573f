#include "session/fit_latency.h"

#include <cmath>
#include <optional>

#include "loop/work_fit.h"
#include "session/frame_camera.h"
#include "session/interrupt.h"
#include "session/scenario_loop.h"
#include "session/session.h"

namespace saccade {
namespace {

/// Processing times of the frame camera's detector.
class FrameTimes final : public LoopObserver {
 public:
  explicit FrameTimes(FrameCamera& camera) : camera_(camera) {}
  void on_tick(const Tick& tick) override {
    camera_.on_tick(tick);
    if (camera_.ready_us()) samples_.push_back({1, 0, static_cast<double>(camera_.find_ns()) * 1e-3});
  }
  [[nodiscard]] WorkTime work() const { return fit_work(samples_); }

 private:
  FrameCamera& camera_;
  std::vector<WorkSample> samples_;
};

}  // namespace

LatencyConfig fit_latency(Scenario scenario) {
  if (scenario.detectors.empty())
    throw InputError("detectors", "none", "a scenario with at least one detector");
  scenario.latency = {};
  SimRobot robot(scenario.sim, static_cast<std::uint64_t>(scenario.seed));
  Loop loop = make_loop(scenario, robot);
  LatencyFit fit(loop);
  Session session(robot, loop);
  session.add_observer(fit);
  std::optional<FrameCamera> frames;
  std::optional<FrameTimes> frame_times;
  if (scenario.frame_30hz) {
    frames.emplace(*scenario.frame_30hz, scenario.sim, scenario.latency, robot);
    session.add_observer(frame_times.emplace(*frames));
  }
  session.run(World::tick_us, std::llround(scenario.run.duration_s * 1e6));
  if (interrupted()) throw RunError("interrupted");
  LatencyConfig latency = fit.latency();
  if (frame_times) latency.detectors.emplace_back(std::string(frame_detector_name), frame_times->work());
  return latency;
}

}  // namespace saccade
