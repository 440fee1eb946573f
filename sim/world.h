#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/config.h"
#include "emulator/event_label.h"
#include "head/head_config.h"
#include "head/head_state.h"
#include "sim/ball.h"
#include "sim/board.h"
#include "sim/body_motion.h"
#include "sim/data_directory.h"
#include "sim/head_mjcf.h"
#include "sim/imu_sensor.h"
#include "sim/mujoco_compat.h"
#include "sim/objects.h"
#include "sim/plant.h"
#include "sim/trajectory.h"

namespace saccade {

struct WorldConfig {
  std::string target = "ball";  ///< what the truth is about: the ball, or the object of this name
  BallConfig ball;
  NamedObjects objects;              ///< other moving objects
  std::optional<BoardConfig> board;  ///< a calibration board, if the scenario has one
  HeadConfig head;
  /// Joint positions at the start, in the order of HeadModel::joints, whose count is that of the elements used; the torso
  /// stays there unless it has a motion of its own.
  std::array<double, joint_slots> initial_pose_deg{};
  PlantConfig plant;
  std::optional<BodyMotionConfig> torso;  ///< motion of the torso's joints about the initial pose
  std::optional<BodyMotionConfig> base;   ///< rotation of the whole robot about the root
  std::optional<ImuConfig> imu;
};

/// Keys: target, ball, objects, board, initial_pose_deg, plant, torso, base, imu; board, torso, base and imu where there are such.
/// The section head comes before them.
void describe(FieldVisitor& v, WorldConfig& config);

/// The initial pose by slot, rad.
[[nodiscard]] JointVector initial_pose_rad(const WorldConfig& config, const HeadModel& head);

/// The simulated world: a torso and head as a dynamic plant with position servos, a ball in a moving hand, other
/// moving objects and a lab around them, in one MuJoCo model. Poses of cameras and geoms always belong to now_us().
/// The same configuration, lab and seed give the same bytes.
class World {
 public:
  static constexpr std::int64_t tick_us = 1000;

  /// Makes the head (head_mjcf), loads `ball_in_hand.xml` and the hand's file from `models` and adds `lab_mjcf`, MJCF elements of the
  /// lab (`<asset>...</asset><worldbody>...</worldbody>`, angles in radians; may be empty). The plant starts
  /// at rest under gravity, references at the initial pose.
  /// Throws InputError for a configuration out of range, for a missing model file, and for files of objects and trajectories
  /// that are wrong; RunError if MuJoCo rejects the model.
  World(const WorldConfig& config, const std::string& lab_mjcf, std::uint64_t seed,
        const std::filesystem::path& models = models_directory());

  /// Advances by one tick. Throws RunError when MuJoCo warns (NaN, no memory, singular inertia).
  void step();
  [[nodiscard]] std::int64_t now_us() const { return now_us_; }

  /// The newest encoder readings.
  [[nodiscard]] HeadState head_state() const;
  /// Ground truth: the joint positions now. With ideal encoders and drives the readings are the same.
  [[nodiscard]] JointVector joints_rad() const;
  /// Sets position references of the head's joints, rad. They apply from the next step on, or later by the plant's
  /// command delay. Returns false, and keeps the last ones, if one is not finite or outside limits().
  bool set_reference(const HeadJointVector& reference_rad);
  [[nodiscard]] const JointLimits& limits() const { return limits_; }
  /// The newest reading of the inertial measurement unit; null without one.
  [[nodiscard]] const ImuReading* imu_reading() const { return imu_ ? &imu_->reading() : nullptr; }

  /// Sets the pose of an eye's camera (left_eye_camera() or right_eye_camera()) in the eye; before it is the identity.
  /// Call at most once per camera.
  void mount_camera(int camera_id, const Eigen::Isometry3d& eye_from_camera);

  /// Ground truth: centre of the target now (an object's origin), root frame; start of its commanded motion.
  [[nodiscard]] Eigen::Vector3d target_position_m() const { return target_position_m(*data_); }
  /// Whether there is a target: a ball, or the object that the configuration names. Without, the position is that of the
  /// ball's trajectory.
  [[nodiscard]] bool has_target() const { return target_ || has_ball_; }
  /// The body of the model that the target is, or its first part.
  [[nodiscard]] int target_body() const;
  /// Radius of a target that is a sphere; none for others.
  [[nodiscard]] std::optional<double> target_radius_m() const;
  [[nodiscard]] std::int64_t first_motion_us() const;
  /// Ground truth: poses of the eyes' cameras now (x right, y down, z along the optical axis), from the plant's joints.
  [[nodiscard]] Eigen::Isometry3d root_from_left_cam() const { return root_from_camera(data(), left_eye_); }
  [[nodiscard]] Eigen::Isometry3d root_from_right_cam() const { return root_from_camera(data(), right_eye_); }
  /// The same for a state filled by show().
  [[nodiscard]] static Eigen::Isometry3d root_from_camera(const mjData& data, int camera_id);
  [[nodiscard]] Eigen::Vector3d target_position_m(const mjData& data) const;

  /// Sets `data`, made with mj_makeData(&model()), to the state at t_us within the last tick, [now - tick, now]: joints
  /// are interpolated (cubic in position and speed), objects follow their trajectories, poses are updated.
  void show(std::int64_t t_us, mjData& data) const;

  /// Sets `data` to given joint positions (order of Joint), for instance of a recording, and objects to their places at
  /// t_us, which may be any time.
  void pose(std::int64_t t_us, const JointVector& position_rad, mjData& data) const;

  /// For renderers. Colours and textures of the model may be changed before the first renderer is made.
  [[nodiscard]] mjModel& model() { return *model_; }
  [[nodiscard]] const mjModel& model() const { return *model_; }
  /// The state of the world now, as cameras see it.
  [[nodiscard]] mjData& data() { return joint_data_ ? *joint_data_ : *data_; }
  [[nodiscard]] const mjData& data() const { return joint_data_ ? *joint_data_ : *data_; }
  /// The SceneObject of each geom of the model, as a number. A target that is another object than the ball is
  /// SceneObject::ball; the ball is then a distractor.
  [[nodiscard]] std::vector<std::uint8_t> scene_objects() const;
  [[nodiscard]] int left_eye_camera() const { return left_eye_; }
  /// That of the left eye where the head has one eye.
  [[nodiscard]] int right_eye_camera() const { return right_eye_; }

 private:
  void find_parts();
  void set_up_drives(const PlantConfig& config);  // in the model: axes, friction; and the backlash
  void place_objects(std::int64_t t_us, mjData& data) const;
  void apply_due_commands();
  void move_torso();
  [[nodiscard]] Eigen::Isometry3d world_from_imu() const;
  void save_last_state();
  void advance();

  struct Motors {  ///< in the order of motors_
    JointVector rad = JointVector::Zero();
    JointVector rad_s = JointVector::Zero();
  };
  [[nodiscard]] Motors motors() const;

  struct Command {
    std::int64_t due_us;
    JointVector motor_rad = JointVector::Zero();
  };

  MjModelPtr model_;
  MjDataPtr data_;        ///< state of the motors; loads move with them as if there were no backlash
  MjDataPtr joint_data_;  ///< state of the joints, if there is backlash
  Trajectory trajectory_;
  std::optional<Objects> objects_;
  std::optional<std::size_t> target_;  ///< index of the object; none: the ball
  JointLimits limits_;
  double ball_radius_m_;
  bool has_ball_;
  bool rolls_;
  std::shared_ptr<const HeadModel> head_;
  MotorCoupling coupling_;
  std::vector<HeadMotor> motors_;
  int ball_mocap_ = 0;
  std::optional<BoardConfig> board_;
  int board_mocap_ = 0;
  int left_eye_ = 0;
  int right_eye_ = 0;
  std::int64_t now_us_ = 0;
  std::vector<mjtNum> last_qpos_;  ///< one tick ago, for show()
  std::vector<mjtNum> last_qvel_;
  JointVector backlash_half_width_rad_ = JointVector::Zero();
  JointVector joint_rad_ = JointVector::Zero();  ///< behind the backlash, in the order of Motors
  JointVector last_joint_rad_ = JointVector::Zero();
  std::optional<Encoders> encoders_;
  std::optional<BodyMotion> torso_motion_;
  JointVector start_rad_ = JointVector::Zero();  ///< the initial pose, by slot
  std::optional<BodyMotion> base_motion_;
  int base_mocap_ = 0;
  int head_body_ = 0;
  std::optional<ImuSensor> imu_;
  std::int64_t command_delay_us_;
  std::deque<Command> commands_;  ///< not yet due
};

}  // namespace saccade
