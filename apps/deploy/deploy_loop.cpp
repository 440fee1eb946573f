#include "apps/deploy/deploy_loop.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>

#include "apps/deploy/edge_check.h"
#include "apps/deploy/steady_check.h"
#include "config/robot_file.h"
#include "session/real_time.h"
#include "session/scenario_loop.h"

namespace saccade {
namespace {

std::string text(ImageSize size) { return fmt::format("{} x {} pixels", size.width, size.height); }

/// Index of the detector that drives the head.
std::optional<std::size_t> driver_of(const RobotFile& file) {
  for (std::size_t i = 0; i < file.detectors.size(); ++i) {
    if (file.detectors[i].first == file.gaze.detector) return i;
  }
  return std::nullopt;
}

}  // namespace

std::vector<StartUpCheck> start_up_checks(Robot& robot, const RobotFile& file) {
  std::vector<StartUpCheck> checks = robot.check();
  const Camera& camera = file.calibration.camera;
  const ImageSize size = robot.events().image_size();
  checks.push_back({"calibration is of this camera", size == camera.size,
                    size == camera.size
                        ? text(size)
                        : fmt::format("events of {}, calibration of {}", text(size), text(camera.size))});
  const bool drives = file.gaze.detector != "none";
  const bool has_head = robot.head() != nullptr;
  checks.push_back({"a head, if gaze.detector drives one", has_head || !drives,
                    has_head ? "found"
                    : drives ? "none"
                             : "none, and none is needed"});
  if (file.robot.backend == "recording")
    return checks;  // it never falls silent, and its time must not pass here
  for (StartUpCheck& check : steady_checks(robot, file.deploy.watchdog)) checks.push_back(std::move(check));
  if (has_head && drives) checks.push_back(halts_check(is_virtual_machine(), file.deploy.watchdog));
  if (file.deploy.edge_check_s > 0.0) {
    for (StartUpCheck& check :
         edge_checks(robot, file.deploy.edge_check_s,
                     file.robot.backend == "yarp" ? "change yarp.camera.swap_polarity"
                                                  : "its driver must send ON for brighter"))
      checks.push_back(std::move(check));
  }
  return checks;
}

Loop make_deploy_loop(Robot& robot, const RobotFile& file) {
  std::optional<LoopGaze> gaze;
  if (const auto driver = driver_of(file); driver && robot.head() != nullptr)
    gaze.emplace(LoopGaze{driver, make_gate(file.gaze.gate), std::nullopt, file.gaze.follow});
  const LoopBudget budget{static_cast<std::size_t>(file.deploy.max_events_per_tick),
                          std::llround(file.deploy.shadows_until_ms * 1e3),
                          std::llround(file.deploy.tick_ms * 1e3) + DetectorRunner::slice_us};
  return Loop(robot, file.calibration, make_detectors(file.detectors, file.calibration.camera),
              std::move(gaze), Eye::left, budget);
}

DeploySession::MakeMotion motion_maker(Robot& robot, const RobotFile& file) {
  if (!driver_of(file) || robot.head() == nullptr) return {};
  return [&robot, &file] {
    LoopMotion motion;
    motion.ramp_in_s = file.deploy.ramp_in_s;
    if (GazePort* const port = robot.gaze()) {
      motion.port = port;
    } else {
      JointLimits limits = robot.head()->limits();
      limits.head = aiming_cameras(limits.head, file.calibration.mount.eye_from_camera(),
                                   Eigen::Isometry3d::Identity());
      motion.controller = make_gaze_controller(file.gaze.controller, limits);
      motion.limiter.emplace(motion_limits(limits, file.gaze.controller.limits));
    }
    return motion;
  };
}

}  // namespace saccade
