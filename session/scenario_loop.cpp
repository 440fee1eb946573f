#include "session/scenario_loop.h"

#include <algorithm>
#include <cstdlib>
#include <string>
#include <utility>

#include "core/error.h"

namespace saccade {
namespace {

/// What `make` makes; the key goes before what stops it, such as a program that is not there.
template <class Make>
auto made_for(const std::string& key, Make make) {
  try {
    return make();
  } catch (const RunError& error) {
    throw RunError(key + ": " + error.what());
  }
}

std::unique_ptr<Detector> named_detector(const std::string& name, const DetectorConfig& config,
                                         const Camera& camera) {
  const std::string key = "detectors." + name;
  try {
    return made_for(key, [&] { return make_detector(config, camera); });
  } catch (const InputError& error) {
    std::vector<Problem> problems = error.problems();
    for (Problem& problem : problems) problem.place = key + "." + problem.place;
    throw InputError(std::move(problems));
  }
}

}  // namespace

JointLimits aiming_limits(const Scenario& scenario, JointLimits limits) {
  const Eigen::Isometry3d left = scenario.calibration.mount.eye_from_camera();
  const Eigen::Isometry3d right = scenario.sim.both_eyes()
                                      ? scenario.right_calibration.mount.eye_from_camera()
                                      : Eigen::Isometry3d::Identity();
  limits.head = aiming_cameras(limits.head, left, right);
  return limits;
}

std::optional<LoopGaze> make_gaze(const Scenario& scenario, const JointLimits& head_limits) {
  const JointLimits limits = aiming_limits(scenario, head_limits);
  const GazeControllerConfig& config = scenario.gaze.controller;
  if (scenario.gaze.detector == "none" && config.follows_targets()) return std::nullopt;
  LoopGaze gaze{{},
                make_gate(scenario.gaze.gate),
                LoopMotion{made_for("gaze.controller", [&] { return make_gaze_controller(config, limits); }),
                           JointLimiter(motion_limits(limits, config.limits))},
                scenario.gaze.follow};
  for (std::size_t i = 0; i < scenario.detectors.size(); ++i) {
    const auto& [name, detector] = scenario.detectors[i];
    if (name != scenario.gaze.detector) continue;
    gaze.driver = i;
    if (scenario.sim.both_eyes() && scenario.gaze.stereo) {
      const MountedCamera& right = scenario.right_calibration;
      gaze.stereo.emplace(LoopStereo{named_detector(name, detector, right.camera), right,
                                     StereoLocator(scenario.gaze.gate.target)});
    }
  }
  return gaze;
}

std::vector<LoopDetector> make_detectors(const NamedDetectors& named, const Camera& camera) {
  std::vector<LoopDetector> detectors;
  for (const auto& [name, config] : named) detectors.push_back({name, named_detector(name, config, camera)});
  return detectors;
}

Loop make_loop(const Scenario& scenario, SimRobot& robot) {
  return make_loop(scenario, robot, make_detectors(scenario.detectors, scenario.calibration.camera),
                   make_gaze(scenario, robot.limits()));
}

Loop make_loop(const Scenario& scenario, SimRobot& robot, std::vector<LoopDetector> detectors,
               std::optional<LoopGaze> gaze) {
  // Detectors whose time is measured do not share the processor's caches with others.
  const bool measured = scenario.latency.kind == LatencyKind::measured;
  return Loop(robot, scenario.calibration, std::move(detectors), std::move(gaze), Eye::left, std::nullopt,
              scenario.latency, measured ? nullptr : robot.threads());
}

void set_rasterisers(std::int64_t threads) {
  // Read by llvmpipe; 0 draws in the calling thread.
  setenv("LP_NUM_THREADS", threads == 1 ? "0" : std::to_string(threads).c_str(), 1);
}

}  // namespace saccade
