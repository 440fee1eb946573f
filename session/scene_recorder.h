#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "loop/loop.h"
#include "sim/scene_outline.h"
#include "sim/sim_robot.h"

namespace saccade {

/// Writes scene.json of a simulated run (docs/run_folder.md): the shapes of its model, and where each body was over time. The
/// page that replays the run draws them. Ground truth.
class SceneRecorder final : public LoopObserver {
 public:
  /// The folder exists. `robot` outlives it and is complete: its textures are painted.
  SceneRecorder(std::filesystem::path folder, const SimRobot& robot);

  void on_tick(const Tick& tick) override;
  /// Writes the file. Throws RunError.
  void commit();

  /// Poses of one body that are kept, at most; of a longer run every second one is dropped, again and again.
  static constexpr std::size_t most_poses = 4'096;

 private:
  struct Pose {
    std::int64_t t_us = 0;
    std::array<double, 7> values{};  ///< x, y, z in m, unit quaternion w, x, y, z; world frame
  };
  struct Body {
    std::vector<Pose> poses;  ///< a body that stands still has one
    Pose newest;
  };

  void take(std::int64_t t_us, std::size_t index);

  std::filesystem::path folder_;
  const SimRobot& robot_;
  SceneOutline scene_;
  std::vector<Body> bodies_;
  std::int64_t step_us_ = 10'000;
  std::int64_t next_us_ = 0;
};

}  // namespace saccade
