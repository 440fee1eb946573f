#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "apps/serve/gaze_geometry.h"
#include "control/head_kinematics.h"
#include "control/ikingaze_controller.h"
#include "core/camera.h"

namespace saccade {

/// Replies to the requests of iKinGazeCtrl, carried out by IkinGazeController. Independent of the network: a request and
/// its reply are text as YARP writes a message, words, numbers and lists in brackets; the position of brackets does not
/// matter. Angles in deg, lengths in m, points in the root frame, pixels of the image without distortion.
///
///     look 3D (x y z)                     [ack], or [nack] if the head cannot look there
///     look mono (left|right u v z)        z: depth along that eye's axis
///     look mono (left|right u v ver a)    a: vergence instead of the depth
///     look stereo (ul vl ur vr)
///     look ang (abs|rel azi ele ver)      azimuth + right, elevation + up, from the head with the neck at 0
///                                         (abs) or from the gaze (rel)
///     get x | q | angles | done           [ack] (x y z) | (torso, head) | (azi ele ver) | 0 or 1
///     get 3D mono|stereo|ang (...)        [ack] (x y z), the target of the same look request
///     get 2D (left|right x y z)           [ack] (u v)
///     get pose left|right|head            [ack] (x y z and axis, angle in rad)
///     set|get Tneck|Teyes|sacc|sact|sinh  times s, saccades 0 or 1, their least angle deg, least interval s
///     set|get vor                         gain of the eyes' compensation of what the gyroscope measures; 5 deg/s dead band
///     set|get ocr                         gain of the eyes' compensation of the commanded motion of the neck
///     set|get track|ntol|stab             stored and returned, without effect
///     bind pitch|roll|yaw min max, bind eyes ver, clear pitch|roll|yaw|eyes
///     get pitch|roll|yaw | eyes           [ack] min max | vergence that the eyes are bound to, -1: to none
///     get ang | ang (x y z)               angles of the fixation point | of a point
///     get sdon | des | vel                no saccade: 1; desired joints | velocities of the head without the torso
///     get 3D proj (left|right u v a b c d)  where the pixel's ray meets the plane a x + b y + c z + d = 0
///     get pid                             [ack] (): there are no options of a stereo tracker
///     set|get tweak                       intrinsics of both cameras, without distortion, and their image sizes
///     register | unregister EVENT, list   motion-onset, motion-done, saccade-onset, saccade-done, suspended, resumed or *;
///                                         every reader of events:o gets every event
///     stop | susp | run | status | get info | stor | rest id | del ids | help
///
/// The reply to anything else is [nack], as to a target farther than farthest_target_m, a gain vor or ocr beyond +-10, and a
/// request whose reply would overflow. Before the first target, after `stop` and while suspended it does not move the
/// head; otherwise it keeps looking at the newest target, also after the client that sent it is gone, as iKinGazeCtrl
/// does. A change of a setting restarts the controller from the head's position.
///
/// May be called from several threads.
class GazeServer {
 public:
  /// Throws InputError for a bad configuration. The head starts at `position_rad`. `has_imu`: the head has an inertial
  /// measurement unit, so that vor and ocr begin with 1 and 0; otherwise with 0 and 1.
  GazeServer(const IkinGazeConfig& gaze, const MotionLimitsConfig& motion, const JointLimits& limits,
             const Camera& left, const Camera& right, const JointVector& position_rad, bool has_imu = false);

  [[nodiscard]] std::string answer(const std::string& request);

  /// Once per control period: the reference of the head, rad; none: the head is not moved. `imu`: the newest reading, not
  /// used if it is older than 40 ms; null without one.
  [[nodiscard]] std::optional<HeadJointVector> step(const HeadState& state, double dt_s,
                                                    const ImuReading* imu = nullptr);

  /// State that iKinGazeCtrl streams.
  struct Report {
    /// With parallel optical axes a distant point on them.
    Eigen::Vector3d fixation_m = Eigen::Vector3d::Zero();
    JointVector position_rad = JointVector::Zero();
    Eigen::Vector3d angles_deg;               ///< azimuth, elevation, vergence
    std::optional<Eigen::Vector3d> target_m;  ///< newest target
    std::vector<std::string> events;          ///< since the last report, named as for `register`
    std::int64_t requests = 0;                ///< that moved the head or changed a setting, so far
  };
  [[nodiscard]] Report report();

 private:
  struct Settings {
    IkinGazeConfig gaze;
    JointLimits limits;  ///< bindings included
    double vor = 0.0;
    double ocr = 1.0;
    std::vector<std::pair<std::string, double>> kept;  ///< settings without effect
  };

  void restart();
  [[nodiscard]] std::string look(RequestWords& words);
  [[nodiscard]] std::string get(RequestWords& words) const;
  [[nodiscard]] std::string set(RequestWords& words);
  [[nodiscard]] std::string bind(RequestWords& words);
  [[nodiscard]] std::string clear(RequestWords& words);
  [[nodiscard]] std::string contexts(const std::string& what, RequestWords& words);
  [[nodiscard]] std::string adopt(Settings settings);
  [[nodiscard]] std::string registered(const std::string& what, RequestWords& words);
  [[nodiscard]] GazeGeometry geometry() const { return {limits_.head->chain, state_.position_rad, cameras_}; }

  std::mutex mutex_;
  MotionLimitsConfig motion_;
  JointLimits limits_;
  std::array<Camera, 2> cameras_;
  Settings settings_;
  std::vector<std::pair<std::int64_t, Settings>> contexts_;
  std::int64_t next_context_ = 1;
  [[nodiscard]] Eigen::Vector3d head_rotation_rad_s(const ImuReading* imu) const;

  std::unique_ptr<IkinGazeController> controller_;
  std::unique_ptr<JointLimiter> limiter_;
  HeadState state_;
  std::optional<Eigen::Vector3d> target_m_;
  bool target_is_new_ = false;
  bool suspended_ = false;
  bool stop_ = false;  ///< at the next step
  JointVector desired_rad_ = JointVector::Zero();
  bool saccade_done_ = true;
  std::vector<std::string> registered_;
  double still_s_ = 0.0;
  bool done_ = true;
  std::vector<std::string> events_;
  std::int64_t requests_ = 0;
};

}  // namespace saccade
