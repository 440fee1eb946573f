#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <string_view>

#include "control/gaze_controller.h"
#include "control/joint_limiter.h"
#include "external/external_config.h"
#include "external/line_process.h"

namespace saccade {

/// A gaze controller in a program of its own, by the protocol of docs/external_controllers.md. Simulated time waits for its
/// answers. A crash, an answer that is no reference, or an answer after the time limit ends it: from then on it keeps its
/// last references, and failure() says why. Nothing else is affected.
///
/// It is asked for references only when the encoders are read, and gets only targets that check_gaze_target() accepts.
class ExternalController final : public GazeController {
 public:
  /// Starts the program or connects to it, and waits for its line `ready`. `name`: for messages. Throws RunError, and ends
  /// the program, where that line does not come.
  ExternalController(std::string name, const LineProcess::Place& place, const AnswerLimits& answers,
                     const MotionLimits& limits);

  HeadJointVector step(const HeadState& state, const std::optional<Eigen::Vector3d>& target_m,
                       double dt_s) override;
  void rest() override { rest_ = true; }
  [[nodiscard]] TargetStatus target_status() const override { return status_; }
  [[nodiscard]] std::string_view failure() const override { return failure_; }

 private:
  void write_step(const HeadState& state, const std::optional<Eigen::Vector3d>& target_m, double dt_s);

  std::string name_;
  LineProcess process_;
  std::chrono::milliseconds answer_limit_;
  MotionLimits limits_;
  HeadJointVector reference_rad_;
  TargetStatus status_ = TargetStatus::none;
  bool rest_ = false;  ///< the next question says so
  std::string message_;
  std::string answer_;
  std::string failure_;
};

/// What a program answers: `reference` and a number for each joint that gaze commands. None where the line is no such
/// answer.
[[nodiscard]] std::optional<HeadJointVector> parse_reference(std::string_view line,
                                                             int joints = head_joint_count);

}  // namespace saccade
