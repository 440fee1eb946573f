#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "core/camera.h"
#include "core/detector_factory.h"
#include "loop/loop.h"
#include "sim/mujoco_compat.h"

namespace saccade {

/// What of one tick goes into the plots; NaN where it does not apply.
struct PlotSample {
  static constexpr float none = std::numeric_limits<float>::quiet_NaN();

  std::int64_t t_us = 0;
  float events = 0.0F;  ///< how many
  std::array<float, 2> truth_px = {none, none};
  std::array<float, 2> found_px = {none,
                                   none};  ///< by the detector that is looked at, at or above its threshold
  float score = none;                      ///< of its estimate
  float threshold = none;
  float gaze_error_deg = none;
  std::array<float, joint_count> joints_deg = {none, none, none, none, none, none, none, none, none};
};

/// What one detector says at an instant.
struct Seen {
  std::string name;
  DetectorTick tick;
  double threshold = 0.0;
};

/// Truth of an instant, and where the gaze is to go; for show alone.
struct ShownTruth {
  std::optional<Circle> circle;
  std::optional<Eigen::Vector2d> target_px;
  std::optional<Eigen::Isometry3d> root_from_cam;
  std::optional<Eigen::Vector3d> target_m;  ///< root
  float gaze_error_deg = PlotSample::none;
};

/// What a person can change while a loop goes on.
struct ViewSettings {
  struct NamedDetector {
    std::string name;
    DetectorConfig config;
    bool on = true;
  };
  std::vector<NamedDetector> detectors;
  std::size_t driver = 0;  ///< of them, always on: the one that is looked at, and that drives a gaze
  std::optional<GazeControllerConfig> controller;  ///< where a head is moved
  std::optional<GateConfig> gate;
};

/// A loop at one instant, as the window shows it: filled in the loop's thread, drawn in the window's.
struct Picture {
  static constexpr std::int64_t events_us = 300'000;  ///< how far back the events reach
  static constexpr std::int64_t plot_us = 4'000'000;  ///< and the plots

  std::int64_t start_us = 0;
  std::int64_t now_us = 0;
  std::int64_t end_us = 0;
  bool playing = false;
  bool seeking = false;
  double speed = 0.0;         ///< that was reached, simulated or recorded time per time
  std::uint64_t handled = 0;  ///< the newest Wishes::version that this picture is of
  std::string problem;        ///< why settings were not taken; empty where they were

  Camera camera;
  std::vector<std::uint8_t> grey;  ///< the eye's image, row by row; empty where there is none
  std::vector<Event> events;       ///< the newest, sorted by time
  std::vector<float> hough;        ///< Detector::hough_space of the driver; empty where it has none
  std::vector<Seen> seen;          ///< of the detectors that are on
  std::size_t driver = 0;          ///< of seen
  std::optional<ShownTruth> truth;
  GazePhase phase = GazePhase::none;
  std::vector<PlotSample> samples;  ///< of the last plot_us
  const mjModel* model = nullptr;   ///< of the world; null where there is none
  MjDataPtr scene;                  ///< the world, where there is one
};

}  // namespace saccade
