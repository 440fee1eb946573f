#pragma once

#include <memory>

#include "robot/robot.h"

namespace saccade {

/// Wraps a robot without moving it: forwards everything except commands, targets, stops, activate() and release(). Rejects
/// the commands that the head would reject.
class DryRobot final : public Robot {
 public:
  explicit DryRobot(std::unique_ptr<Robot> robot);

  Clock& clock() override { return robot_->clock(); }
  EventSource& events() override { return robot_->events(); }
  HeadPort* head() override { return robot_->head() != nullptr ? &head_ : nullptr; }
  GazePort* gaze() override { return robot_->gaze() != nullptr ? &gaze_ : nullptr; }
  std::vector<StartUpCheck> check() override { return robot_->check(); }
  void activate() override {}
  void release() override {}
  void halt() override {}
  std::vector<std::string> news() override { return robot_->news(); }

 private:
  class DryHead final : public HeadPort {
   public:
    explicit DryHead(HeadPort* head) : head_(head) {}
    [[nodiscard]] JointLimits limits() const override { return head_->limits(); }
    PortStatus read(HeadState& state) override { return status_ = head_->read(state); }
    CommandResult command(const HeadCommand& reference_rad) override {
      return {status_, !is_allowed(reference_rad, head_->limits())};
    }
    PortStatus stop() override { return status_; }

   private:
    HeadPort* head_;
    PortStatus status_ = PortStatus::ok;  // of the last reading
  };
  class DryGaze final : public GazePort {
   public:
    PortStatus look_at(const Eigen::Vector3d&) override { return PortStatus::ok; }
    PortStatus stop() override { return PortStatus::ok; }
  };

  std::unique_ptr<Robot> robot_;
  DryHead head_;
  DryGaze gaze_;
};

inline DryRobot::DryRobot(std::unique_ptr<Robot> robot) : robot_(std::move(robot)), head_(robot_->head()) {}

}  // namespace saccade
