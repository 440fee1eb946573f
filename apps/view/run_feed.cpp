#include "apps/view/run_feed.h"

#include <cmath>

#include "apps/view/sim_snapshot.h"
#include "config/scenario.h"
#include "sim/sim_robot.h"

namespace saccade {

RunFeed::RunFeed(const Scenario& scenario)
    : camera_(scenario.sim.camera),
      driver_(scenario.gaze.detector),
      history_(scenario.sim.camera, Eye::left, 0, std::llround(scenario.run.duration_s * 1e6)) {}

void RunFeed::record(const Tick& tick, const SimRobot& robot, const Loop& loop) {
  std::size_t selected = 0;
  for (std::size_t i = 0; i < loop.detectors().size(); ++i) {
    if (loop.detectors()[i].name == driver_) selected = i;
  }
  history_.record(tick, simulated_truth(robot, camera_, tick), loop, selected);
  if (!channel_.requested()) return;
  if (!model_) model_ = copy_of_model(robot.world());
  Snapshot& snapshot = channel_.back();
  history_.fill(snapshot, loop);
  fill_simulated(robot, model_, snapshot);
  snapshot.playing = true;
  channel_.publish();
}

}  // namespace saccade
