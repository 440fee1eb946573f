#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <span>
#include <string_view>

#include "core/camera.h"
#include "core/event.h"

namespace saccade {

/// Pose and velocity of the camera at one instant, from the encoders and the kinematics of the head. Recordings without
/// joints have none (nullptr).
struct CameraMotion {
  Eigen::Isometry3d root_from_camera = Eigen::Isometry3d::Identity();
  Eigen::Vector3d linear_velocity_m_s = Eigen::Vector3d::Zero();     ///< of the pinhole, camera frame
  Eigen::Vector3d angular_velocity_rad_s = Eigen::Vector3d::Zero();  ///< camera frame
};

/// The best circle of a detector at one instant. `valid` is false before the first event.
struct Estimate {
  bool valid = false;
  /// True if the estimate is held or predicted instead of measured from current events. It counts as an observation even
  /// without events (docs/scoring.md).
  bool held = false;
  Circle circle;
  double score = 0.0;  ///< confidence, compared with threshold(); the scale depends on the detector
  /// Covariance of (x, y, r), px^2; zero for a detector that does not estimate it.
  Eigen::Matrix3d covariance_px2 = Eigen::Matrix3d::Zero();
};

/// Counts of the events that a detector could not use and ignored.
struct RejectedEvents {
  std::int64_t outside_image = 0;
  std::int64_t back_in_time = 0;  ///< earlier than an accepted event
};

/// Finds the ball in a stream of events from one camera. A detector has no clock, file or thread.
///
/// The caller passes events sorted by time, then the current time, then gets the estimate:
///
///     detector.process(events, motion);      // every event with t <= now, once
///     detector.advance_to(now_us, motion);   // also without events
///     Estimate e = detector.estimate();      // the best circle at now_us
///     detector.work_ahead();                 // optional
///
/// None of them allocates, throws or logs.
class Detector {
 public:
  virtual ~Detector() = default;

  virtual void process(std::span<const Event> events, const CameraMotion* motion) = 0;
  virtual void advance_to(std::int64_t now_us, const CameraMotion* motion) = 0;
  /// The best circle after all events so far; it does not change until more events or time are passed.
  [[nodiscard]] virtual Estimate estimate() = 0;
  /// Optional work between ticks that shortens the next process() or advance_to() and changes no result. May run in another
  /// thread while no other function of the detector runs. After it, estimate() is called only after one of those two.
  virtual void work_ahead() {}
  /// For a caller that is behind: work of the time before t_us that only serves later estimates, such as a search for new
  /// circles, may be left out in the calls that follow. A detector that is never told so does all its work.
  virtual void leave_out_work_before(std::int64_t /*t_us*/) {}
  /// The score from which on an estimate counts as the ball; a constant of the configuration.
  [[nodiscard]] virtual double threshold() const = 0;
  [[nodiscard]] virtual RejectedEvents rejected() const = 0;
  /// Why the detector has ended and estimates nothing any more: one line, empty while it works. Only detectors outside of
  /// this program end (external).
  [[nodiscard]] virtual std::string_view failure() const { return {}; }
};

}  // namespace saccade
