#pragma once

#include <vector>

#include "apps/deploy/deploy_session.h"
#include "loop/loop.h"
#include "robot/robot.h"

namespace saccade {

struct RobotFile;

/// The parts of a deployed loop as a robot file describes them. Robot and file outlive what is made of them.

/// The robot's own checks and those that need the file. Moves nothing.
[[nodiscard]] std::vector<StartUpCheck> start_up_checks(Robot& robot, const RobotFile& file);
/// A loop that does not move the head before Loop::set_motion.
[[nodiscard]] Loop make_deploy_loop(Robot& robot, const RobotFile& file);
/// Makes what moves the head, anew for each activation; empty if `gaze.detector` is none or there is no head.
[[nodiscard]] DeploySession::MakeMotion motion_maker(Robot& robot, const RobotFile& file);

}  // namespace saccade
