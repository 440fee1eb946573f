#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "core/camera.h"
#include "core/event.h"
#include "core/flow/camera_rotation.h"
#include "core/flow/plane_fit_flow.h"
#include "core/reserved_vector.h"

namespace saccade {

/// The rotation of a camera that the motion of its whole image shows, from events alone: independent of detectors, robust to
/// objects that move by themselves (camera_rotation).
///
/// Of the events of each millisecond at most 32, evenly spaced, get a plane-fit normal flow. Every 4 ms camera_rotation() is
/// fitted to the flows of the last 16 ms. A flow itself is the mean over the time in which its edge passed about three
/// pixels, so that the result is older the slower the image moves: docs/oculomotor.md has figures. Edges slower than 2.5 px/s
/// have no flow.
class ImageRotation {
 public:
  static constexpr std::int64_t window_us = 16'000;
  static constexpr std::int64_t period_us = 4'000;

  explicit ImageRotation(const Camera& camera);

  /// Adds events sorted by time; those outside the image are ignored. Allocates nothing.
  void process(std::span<const Event> events);
  /// Call once per millisecond. Every period_us: the camera's rotation, rad/s in its own frame; zero where the flows do not agree
  /// on one. None in between, and where there are too few flows.
  [[nodiscard]] std::optional<Eigen::Vector3d> advance_to(std::int64_t now_us);

 private:
  static constexpr std::size_t most_flows = 512;
  static constexpr std::size_t flows_per_call = 32;
  static constexpr std::size_t fewest_flows = 60;

  struct TimedFlow {
    std::int64_t t_us = 0;
    FlowSample flow;
  };
  Camera camera_;
  std::vector<Eigen::Vector3d> rays_;
  PlaneFitFlow flow_;
  std::array<TimedFlow, most_flows> recent_;  // a ring
  std::size_t count_ = 0;
  ReservedVector<FlowSample> used_;
  std::int64_t next_us_ = std::numeric_limits<std::int64_t>::min();
  Eigen::Vector3d rotation_rad_s_ = Eigen::Vector3d::Zero();
};

}  // namespace saccade
