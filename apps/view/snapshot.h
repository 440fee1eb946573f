#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/camera.h"
#include "loop/loop.h"
#include "sim/mujoco_compat.h"

namespace saccade {

/// NaN for each joint that gaze commands.
constexpr std::array<float, gaze_slots> no_joints() {
  std::array<float, gaze_slots> all{};
  all.fill(std::numeric_limits<float>::quiet_NaN());
  return all;
}

/// The values of one tick that the plots show; NaN where one does not apply.
struct PlotSample {
  static constexpr float none = std::numeric_limits<float>::quiet_NaN();

  std::int64_t t_us = 0;
  float events = 0.0F;  ///< number of events in the tick
  std::array<float, 2> truth_px = {none, none};
  std::array<float, 2> detected_px = {none, none};  ///< by the selected detector, at or above its threshold
  float score = none;                               ///< of its estimate
  float threshold = none;
  float gaze_error_deg = none;
  std::array<float, gaze_slots> joints_deg = no_joints();  ///< those that gaze commands
};

/// The output of one detector in the newest tick.
struct DetectorOutput {
  std::string name;
  DetectorTick tick;
  double threshold = 0.0;
  std::string failure = {};  ///< why the detector has ended, Detector::failure(); empty: it has not
};

/// Ground truth and gaze target of an instant, for display alone.
struct SnapshotTruth {
  std::optional<Circle> circle;
  std::optional<std::array<Eigen::Vector2d, 2>>
      box_px;  ///< top left and bottom right of a target that is no sphere
  std::optional<Eigen::Vector2d> target_px;
  std::optional<Eigen::Isometry3d> root_from_cam;
  std::optional<Eigen::Vector3d> target_m;  ///< root frame
  float gaze_error_deg = PlotSample::none;  ///< angle between optical axis and ball
};

/// The state of a loop at one instant, as the window shows it. The loop's thread fills it, the window's thread draws it.
/// It refers to nothing that the loop's thread may destroy.
struct Snapshot {
  static constexpr std::int64_t events_us = 300'000;  ///< time span of `events`
  static constexpr std::int64_t plot_us = 4'000'000;  ///< time span of `samples`

  std::int64_t start_us = 0;
  std::int64_t now_us = 0;
  std::int64_t end_us = 0;
  bool playing = false;
  bool seeking = false;
  double speed = 0.0;         ///< reached: simulated or recorded time per wall-clock time
  std::uint64_t request = 0;  ///< number of the newest request (PlayerThread) that this snapshot includes
  std::string problem;        ///< why settings were rejected; empty where they were applied

  Camera camera;
  std::vector<std::uint8_t> grey;       ///< image of the eye's camera, row by row; empty where there is none
  std::vector<Event> events;            ///< of the last events_us, sorted by time
  std::vector<float> hough;             ///< Hough space of the selected detector; empty where it has none
  std::vector<DetectorOutput> outputs;  ///< of the enabled detectors
  std::size_t selected = 0;             ///< index in `outputs`; beyond their end where there is no detector
  std::optional<SnapshotTruth> truth;
  GazePhase phase = GazePhase::none;
  std::vector<PlotSample> samples;  ///< of the last plot_us
  std::vector<std::string>
      joint_names;  ///< of the joints that gaze commands, in the order of joints_deg; empty without head
  std::shared_ptr<const mjModel> model;  ///< of the world; null where there is none
  MjDataPtr scene;                       ///< state of the world; null where there is none

  /// Output of the selected detector; null where there is none.
  [[nodiscard]] const DetectorOutput* selected_output() const {
    return selected < outputs.size() ? &outputs[selected] : nullptr;
  }
  /// Seconds from the start to t_us.
  [[nodiscard]] double since_start_s(std::int64_t t_us) const {
    return static_cast<double>(t_us - start_us) * 1e-6;
  }
  /// Sets `model` and makes `scene` a state of it. Throws RunError when there is no memory for it.
  void use_model(const std::shared_ptr<const mjModel>& new_model);
};

}  // namespace saccade
