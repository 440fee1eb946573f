#include "external/external_controller.h"

#include "core/error.h"
#include "external/line_text.h"

namespace saccade {
namespace {

std::string reference_form(int joints) {
  return "`reference` and " + (joints == head_joint_count ? "six" : std::to_string(joints)) + " angles, rad";
}

}  // namespace

std::optional<HeadJointVector> parse_reference(std::string_view line, int joints) {
  if (next_word(line) != "reference") return std::nullopt;
  HeadJointVector reference_rad = HeadJointVector::Zero();
  for (int j = 0; j < joints; ++j) {
    const auto number = next_number(line);
    if (!number) return std::nullopt;
    reference_rad[j] = *number;
  }
  return next_word(line).empty() ? std::optional(reference_rad) : std::nullopt;
}

ExternalController::ExternalController(std::string name, const LineProcess::Place& place,
                                       const AnswerLimits& answers, const MotionLimits& limits)
    : name_(std::move(name)),
      process_(place, milliseconds(answers.start_limit_s)),
      answer_limit_(milliseconds(answers.answer_limit_s)),
      limits_(limits),
      reference_rad_(HeadJointVector::Zero().cwiseMax(limits.min_rad).cwiseMin(limits.max_rad)) {
  message_ = "saccade-controller 1\nlimits";
  for (const HeadJointVector& row : {limits.min_rad, limits.max_rad, limits.speed_rad_s}) {
    for (int j = 0; j < limits.joints; ++j) append_word(message_, row[j]);
  }
  message_ += '\n';
  const auto limit = milliseconds(answers.start_limit_s);
  const LineProcess::Status status = process_.exchange(message_, limit, answer_);
  if (status != LineProcess::Status::ok) {
    throw RunError("gaze controller " + end_program(process_, status, name_, "at its start", limit));
  }
  if (const auto failure = stated_failure(process_, answer_, name_, "at its start"))
    throw RunError("gaze controller " + *failure);
  if (answer_ != "ready")
    throw RunError("gaze controller " + name_ + " answered " + shown(answer_) +
                   " at its start, expected `ready`");
}

void ExternalController::write_step(const HeadState& state, const std::optional<Eigen::Vector3d>& target_m,
                                    double dt_s) {
  message_ = "step";
  append_word(message_, dt_s);
  for (const HeadJoint& joint : limits_.head->joints) append_word(message_, state.position_rad[joint.slot]);
  if (target_m) {
    for (const double value : *target_m) append_word(message_, value);
  } else {
    message_ += rest_ ? " rest" : " none";
  }
  message_ += '\n';
  rest_ = false;
}

HeadJointVector ExternalController::step(const HeadState& state,
                                         const std::optional<Eigen::Vector3d>& target_m, double dt_s) {
  status_ = TargetStatus::none;
  if (!is_finite(state)) return reference_rad_;
  if (target_m)
    status_ = check_gaze_target(*target_m, HeadKinematics(limits_.head->chain, state.position_rad));
  if (!failure_.empty()) return reference_rad_;
  write_step(state, status_ == TargetStatus::ok ? target_m : std::nullopt, dt_s);
  const LineProcess::Status status = process_.exchange(message_, answer_limit_, answer_);
  const auto reference_rad =
      status == LineProcess::Status::ok ? parse_reference(answer_, limits_.joints) : std::nullopt;
  if (reference_rad) {
    reference_rad_ = reference_rad->cwiseMax(limits_.min_rad).cwiseMin(limits_.max_rad);
    return reference_rad_;
  }
  const std::string moment = moment_of(state.t_us);
  if (const auto stated =
          stated_failure(process_, status == LineProcess::Status::ok ? answer_ : "", name_, moment)) {
    failure_ = *stated;
  } else if (status == LineProcess::Status::ok) {
    process_.end(std::chrono::milliseconds(0));
    failure_ =
        name_ + " answered " + shown(answer_) + " " + moment + ", expected " + reference_form(limits_.joints);
  } else {
    failure_ = end_program(process_, status, name_, moment, answer_limit_);
  }
  return reference_rad_;
}

}  // namespace saccade
