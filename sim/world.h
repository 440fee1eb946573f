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
#include "core/event_label.h"
#include "head/head_state.h"
#include "sim/board.h"
#include "sim/mujoco_compat.h"
#include "sim/objects.h"
#include "sim/plant.h"
#include "sim/trajectory.h"

namespace saccade {

struct BallConfig {
  double diameter_m = 0.095;
  std::vector<double> rgb = {0.65, 0.10, 0.07};  ///< reflectance, linear; one colour all over, matt
  std::string sleeve = "plain";                  ///< of the arm that holds it: plain or checked
  TrajectoryConfig trajectory;
};

/// Keys: diameter_m, rgb, sleeve, trajectory.
void describe(FieldVisitor& v, BallConfig& config);

struct WorldConfig {
  BallConfig ball;
  NamedObjects objects;              ///< what else moves
  std::optional<BoardConfig> board;  ///< to calibrate with, where a scenario asks for it
  /// Where the joints are and are held at the start, in the order of Joint; the torso stays there.
  std::vector<double> initial_pose_deg = std::vector<double>(joint_count, 0.0);
  PlantConfig plant;
};

/// Keys: ball, objects, board (where there is one), initial_pose_deg, plant.
void describe(FieldVisitor& v, WorldConfig& config);

/// Where the MJCF models of this build are.
[[nodiscard]] std::filesystem::path models_directory();

/// The simulated robot and what it looks at: an iCub torso and head as a dynamic plant with position
/// servos, a ball in a moving hand, what else moves, and a lab around them, in one MuJoCo model. Everything derived from
/// the joints (cameras, geoms) belongs to now_us() at any time. Same configuration, lab and seed: the same
/// bytes.
class World {
 public:
  static constexpr std::int64_t tick_us = 1000;

  /// Loads `icub_head.xml` and `ball_in_hand.xml` from `models` and adds `lab_mjcf`, MJCF elements of the
  /// lab (`<asset>...</asset><worldbody>...</worldbody>`, angles in radians; may be empty). The plant starts
  /// at rest under gravity, references at the initial pose.
  /// Throws InputError for a configuration out of range and for a model file that is missing, RunError when
  /// MuJoCo refuses the model.
  World(const WorldConfig& config, const std::string& lab_mjcf, std::uint64_t seed,
        const std::filesystem::path& models = models_directory());

  /// Advances by one tick. Throws RunError when MuJoCo warns (NaN, no memory, singular inertia).
  void step();
  [[nodiscard]] std::int64_t now_us() const { return now_us_; }

  /// What the encoders say now.
  [[nodiscard]] HeadState head_state() const;
  /// Truth: where the joints are now. With encoders and drives that are perfect the same.
  [[nodiscard]] JointVector joints_rad() const;
  /// Position references of the head's joints, rad, from the next step on or as much later as the plant
  /// delays commands. False, and the last ones hold, when one is not finite or outside limits().
  bool set_reference(const HeadJointVector& reference_rad);
  [[nodiscard]] const JointLimits& limits() const { return limits_; }

  /// Where an eye's camera (left_eye_camera() or right_eye_camera()) sits in the eye from now on; at the start it is
  /// the eye's frame. Once for each.
  void mount_camera(int camera_id, const Eigen::Isometry3d& eye_from_camera);

  /// Truth: ball centre now, root frame; start of its commanded motion.
  [[nodiscard]] Eigen::Vector3d ball_position_m() const { return ball_position_m(*data_); }
  [[nodiscard]] double ball_radius_m() const { return ball_radius_m_; }
  [[nodiscard]] std::int64_t first_motion_us() const { return trajectory_.first_motion_us(); }
  /// Truth: the eyes' cameras now (x right, y down, z along the optical axis), from the plant's joints.
  [[nodiscard]] Eigen::Isometry3d root_from_left_cam() const { return root_from_camera(data(), left_eye_); }
  [[nodiscard]] Eigen::Isometry3d root_from_right_cam() const { return root_from_camera(data(), right_eye_); }
  /// The same for a state filled by show().
  [[nodiscard]] static Eigen::Isometry3d root_from_camera(const mjData& data, int camera_id);
  [[nodiscard]] Eigen::Vector3d ball_position_m(const mjData& data) const;

  /// Puts `data`, made with mj_makeData(&model()), to time t_us within the last tick, [now - tick, now]:
  /// joints interpolated (cubic in position and speed), the ball where it was, all that is drawn derived.
  void show(std::int64_t t_us, mjData& data) const;

  /// Puts `data` to what a recording tells: these joints (order of Joint) and everything else where it is at t_us,
  /// whatever the world's own time.
  void pose(std::int64_t t_us, const JointVector& position_rad, mjData& data) const;

  /// For the renderer; the model's colours and textures may be changed before the first picture.
  [[nodiscard]] mjModel& model() { return *model_; }
  [[nodiscard]] const mjModel& model() const { return *model_; }
  /// The world now, as it is seen.
  [[nodiscard]] mjData& data() { return seen_ ? *seen_ : *data_; }
  [[nodiscard]] const mjData& data() const { return seen_ ? *seen_ : *data_; }
  /// The SceneObject of each geom of the model, as a number.
  [[nodiscard]] std::vector<std::uint8_t> scene_objects() const;
  [[nodiscard]] int left_eye_camera() const { return left_eye_; }
  [[nodiscard]] int right_eye_camera() const { return right_eye_; }

 private:
  void find_parts();
  void make_ball(const BallConfig& config);     // in the model: size, colour, the hand around it
  void make_drives(const PlantConfig& config);  // in the model: axes, friction; and the play behind motors
  void place_objects(std::int64_t t_us, mjData& data) const;
  void obey();
  void remember();
  void advance();

  struct Motors {  ///< the last two those of the left and right eye's pan
    JointVector rad;
    JointVector rad_s;
  };
  [[nodiscard]] Motors motors() const;

  struct Command {
    std::int64_t due_us;
    JointVector motor_rad;
  };

  MjModelPtr model_;
  MjDataPtr data_;  ///< the motors: what they carry moves with them as if there were no play
  MjDataPtr seen_;  ///< the joints behind them, where there is play
  Trajectory trajectory_;
  std::optional<Objects> objects_;
  JointLimits limits_;
  double ball_radius_m_ = 0.0;
  std::array<int, joint_count> joint_{};     ///< MuJoCo joint; the last two are the left and right eye pan
  std::array<int, joint_count> actuator_{};  ///< its servo
  int ball_mocap_ = 0;
  std::optional<BoardConfig> board_;
  int board_mocap_ = 0;
  int left_eye_ = 0;
  int right_eye_ = 0;
  std::int64_t now_us_ = 0;
  std::vector<mjtNum> last_qpos_;  ///< one tick ago, for show()
  std::vector<mjtNum> last_qvel_;
  JointVector half_play_rad_ = JointVector::Zero();
  JointVector joint_rad_;  ///< behind the play, in the order of Motors
  JointVector last_joint_rad_;
  std::optional<Encoders> encoders_;
  std::int64_t command_delay_us_;
  std::deque<Command> commands_;  ///< that are not due yet
};

}  // namespace saccade
