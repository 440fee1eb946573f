#pragma once

#include <Eigen/Core>
#include <vector>

namespace saccade {

/// The control mode of a joint: the modes of the iCub's control boards that saccade serve supports.
enum class JointMode {
  idle,      ///< rejects commands. A simulated joint has no motor to switch off: it holds its position
  position,  ///< moves to a position at its reference speed, with minimum jerk
  direct,    ///< the command is the reference
  velocity,  ///< the reference moves at the commanded velocity
  mixed,     ///< moves of position mode, to which the movement at the commanded velocity adds
};

/// Converts the commands of a control board to references of the position servos. Any number of joints, each in its own
/// mode. rad, rad/s, s.
///
/// As on the iCub: a command for another mode than that of the joint is rejected; positions and speeds are clamped to the
/// limits; a velocity is 0 from velocity_timeout_s after the last command on; a direct reference holds without limit.
/// After a change of mode a joint holds its measured position.
class JointBoard {
 public:
  struct Joint {
    double min_rad = 0.0;
    double max_rad = 0.0;
    double max_speed_rad_s = 0.0;
  };
  static constexpr double velocity_timeout_s = 0.1;
  static constexpr double default_speed_rad_s = 0.174532925199432958;  ///< 10 deg/s
  static constexpr double default_acceleration_rad_s2 =
      17.4532925199432958;  ///< 1000 deg/s^2, in velocity and mixed mode

  /// All joints start at `position_rad` in position mode, as after calibration. `movable` false: they stay idle.
  JointBoard(const std::vector<Joint>& joints, const Eigen::VectorXd& position_rad, bool movable);

  [[nodiscard]] int size() const { return static_cast<int>(axes_.size()); }
  [[nodiscard]] const Joint& joint(int j) const { return at(j).joint; }

  [[nodiscard]] JointMode mode(int j) const { return at(j).mode; }
  bool set_mode(int j, JointMode mode);  ///< false: rejected

  bool move_to(int j, double position_rad);                  ///< position and mixed mode
  bool set_speed(int j, double speed_rad_s);                 ///< of move_to, above 0; any mode
  bool set_reference(int j, double position_rad);            ///< direct mode
  bool set_velocity(int j, double velocity_rad_s);           ///< velocity and mixed mode
  bool set_acceleration(int j, double acceleration_rad_s2);  ///< of set_velocity, above 0; any mode
  void stop(int j);                                          ///< the joint holds its measured position

  [[nodiscard]] double speed_rad_s(int j) const { return at(j).speed_rad_s; }
  [[nodiscard]] double acceleration_rad_s2(int j) const { return at(j).acceleration_rad_s2; }
  [[nodiscard]] double target_rad(int j) const { return at(j).target_rad; }  ///< of the last move_to
  [[nodiscard]] double reference_rad(int j) const { return at(j).reference_rad; }
  [[nodiscard]] double velocity_rad_s(int j) const {
    return at(j).wanted_rad_s;
  }                                                                ///< of the last set_velocity
  [[nodiscard]] bool moving(int j) const { return at(j).moving; }  ///< a move_to is under way

  /// Advances by dt_s. `measured_rad`: the current joint positions. Returns the references from now on.
  const Eigen::VectorXd& step(const Eigen::VectorXd& measured_rad, double dt_s);

 private:
  struct Axis {
    Joint joint;
    JointMode mode;
    double measured_rad = 0.0;
    double reference_rad = 0.0;
    double speed_rad_s = default_speed_rad_s;
    double acceleration_rad_s2 = default_acceleration_rad_s2;
    double from_rad = 0.0, target_rad = 0.0;  // of the move under way
    double moved_s = 0.0, move_s = 0.0;
    bool moving = false;
    double wanted_rad_s = 0.0, now_rad_s = 0.0;  // velocity and mixed mode
    double since_velocity_s = 0.0;

    [[nodiscard]] bool takes_velocities() const {
      return mode == JointMode::velocity || mode == JointMode::mixed;
    }
    void hold();
    void step(double dt_s);
  };
  [[nodiscard]] const Axis& at(int j) const;
  [[nodiscard]] Axis& at(int j);

  std::vector<Axis> axes_;
  Eigen::VectorXd reference_rad_;
  bool movable_;
};

}  // namespace saccade
