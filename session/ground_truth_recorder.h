#pragma once

#include <array>
#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "config/scenario.h"
#include "core/random.h"
#include "loop/loop.h"
#include "recording/array_file.h"
#include "sim/sim_robot.h"
#include "sim/true_image.h"

namespace saccade {

/// Writes ground_truth.h5 or ground_truth.npz of a simulated run, instant by instant (docs/ground_truth.md): an observer, whose
/// images are drawn beside those of the event camera and change nothing in the run.
class GroundTruthRecorder final : public LoopObserver {
 public:
  /// The folder exists; the others outlive it. `scenario` has a block output.ground_truth.
  GroundTruthRecorder(const std::filesystem::path& folder, const Scenario& scenario, SimRobot& robot);

  void on_tick(const Tick& tick) override;
  /// Writes the last instant and closes the file under its final name.
  void commit();
  /// Wall-clock time spent here, s.
  [[nodiscard]] double wall_s() const { return wall_s_; }

 private:
  /// Numbers of the arrays of an eye; those that are off are not set.
  struct EyeArrays {
    std::size_t image = 0, frame = 0, depth = 0, flow = 0, camera_flow = 0, segmentation = 0, pose = 0;
  };

  void add_arrays();
  void add_camera(const std::string& eye, const MountedCamera& camera);
  void write_instant();
  void write_poses();
  void write_flow(const WorldPoses& after);
  void expose(std::int64_t t_us);
  void write_frames();
  [[nodiscard]] bool is_instant(std::int64_t t_us) const { return t_us % config_.period_us() == 0; }

  const Scenario& scenario_;
  GroundTruthConfig config_;
  SimRobot& robot_;
  std::unique_ptr<ArrayFile> file_;
  std::size_t eyes_;
  std::size_t pixels_;
  ObjectTable objects_;
  RandomStream noise_;
  std::size_t t_ = 0, bodies_ = 0, target_ = 0, joints_ = 0;
  std::size_t imu_t_ = 0, gyroscope_ = 0, accelerometer_ = 0;
  std::array<EyeArrays, 2> arrays_;
  std::array<TrueImage, 2> images_;
  std::array<std::vector<float>, 2> luminance_;
  std::array<std::vector<double>, 2> exposed_;  ///< sums of luminance
  std::int64_t exposures_ = 0;
  std::uint64_t frames_ = 0;
  std::vector<float> flow_, camera_flow_;
  std::optional<WorldPoses> last_;     ///< of the tick before
  std::optional<WorldPoses> before_;   ///< before the instant whose flow is not written yet
  std::optional<WorldPoses> instant_;  ///< at it
  double wall_s_ = 0.0;
};

}  // namespace saccade
