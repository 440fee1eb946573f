#pragma once

#include <mujoco/mujoco.h>

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "head/head_model.h"

namespace saccade {

/// The MJCF of a head: a file of its own (HeadModel::mjcf), or made from its description. For an iCub `models` holds
/// icub_head.xml, version 2: the other versions are that file with the places and axes of their own chain.
/// Throws InputError for a missing file.
[[nodiscard]] std::string head_mjcf(const HeadModel& head, const std::filesystem::path& models);

/// A motor of the plant: a hinge of the chain with its joint and servo in a MuJoCo model.
struct HeadMotor {
  int joint = 0;     ///< in the model
  int actuator = 0;  ///< its position servo
  JointRole role = JointRole::neck;
};

/// Finds the hinges of a head in a model that was made from head_mjcf() or from a file, in the order of hinges_at_zero().
/// Throws InputError, whose place is `model_name`, where one is missing or where the model's chain is not the head's: at
/// several poses each camera is compared with the eye, to 1e-9 m and 1e-9 rad.
[[nodiscard]] std::vector<HeadMotor> find_motors(const HeadModel& head, const mjModel& model,
                                                 const std::string& model_name);

/// The rotations of motors that joints make, and the joints that motors make; in the order of the motors and by slot.
class MotorCoupling {
 public:
  explicit MotorCoupling(const HeadModel& head);

  [[nodiscard]] JointVector motors_from_joints(const JointVector& by_slot) const;
  [[nodiscard]] JointVector joints_from_motors(const JointVector& motors) const;

 private:
  struct Term {
    int to;
    int from;
    double share;
  };
  std::vector<Term> motor_terms_;
  std::vector<Term> joint_terms_;
};

/// Numbers as MJCF has them, with 15 digits.
[[nodiscard]] std::string mjcf_numbers(std::span<const double> values);
[[nodiscard]] std::string mjcf_numbers(const Eigen::Vector3d& v);
[[nodiscard]] std::string mjcf_numbers(double value);

/// The names of the cameras of the left and right eye in a model.
inline constexpr const char* eye_camera_names[2] = {"left_eye", "right_eye"};

}  // namespace saccade
