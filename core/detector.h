#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <span>

#include "core/camera.h"
#include "core/event.h"

namespace saccade {

/// Where the camera is and how it moves at one instant, from the encoders and the head's kinematics.
/// Absent (nullptr) on a recording without joints.
struct CameraMotion {
  Eigen::Isometry3d root_from_camera = Eigen::Isometry3d::Identity();
  Eigen::Vector3d linear_velocity_m_s = Eigen::Vector3d::Zero();     ///< of the pinhole, camera frame
  Eigen::Vector3d angular_velocity_rad_s = Eigen::Vector3d::Zero();  ///< camera frame
};

/// A detector's best circle now. Before any event there is none (`valid` false).
struct Estimate {
  bool valid = false;
  /// True when it is held or predicted rather than measured from events up to now (design: such an
  /// estimate counts as an observation even when no event came).
  bool held = false;
  Circle circle;
  double score = 0.0;  ///< confidence, compared with threshold(); its scale is the detector's own
};

/// What a detector met in its input that it could not use. Such events are counted and left out.
struct RejectedEvents {
  std::int64_t outside_image = 0;
  std::int64_t back_in_time = 0;  ///< earlier than an event before it
};

/// Finds the ball in a stream of events from one camera. No detector has a clock, a file or a thread.
///
/// The caller passes events sorted by time, then says how far time has come, then asks:
///
///     detector.process(events, motion);      // every event with t <= now, once
///     detector.advance_to(now_us, motion);   // time passes without events too
///     Estimate e = detector.estimate();      // the best circle at now_us
///
/// None of the three allocates, throws or logs.
class Detector {
 public:
  virtual ~Detector() = default;

  virtual void process(std::span<const Event> events, const CameraMotion* motion) = 0;
  virtual void advance_to(std::int64_t now_us, const CameraMotion* motion) = 0;
  /// The best circle over everything processed so far; the same until more is processed.
  [[nodiscard]] virtual Estimate estimate() = 0;
  /// Score at and above which an estimate is taken for the ball; a constant of the configuration.
  [[nodiscard]] virtual double threshold() const = 0;
  [[nodiscard]] virtual RejectedEvents rejected() const = 0;
  /// For pictures: the largest response over all radii at each pixel as of the last estimate(), row by row;
  /// `response` has room for the image. False, and nothing is written, where a detector has no such space. May
  /// allocate: not for the tick.
  [[nodiscard]] virtual bool hough_space(std::span<float> /*response*/) const { return false; }
  /// One in the same state, which goes on from there as this one would. Allocates: not for the tick.
  [[nodiscard]] virtual std::unique_ptr<Detector> copy() const = 0;
};

}  // namespace saccade
