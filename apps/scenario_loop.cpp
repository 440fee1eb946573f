#include "apps/scenario_loop.h"

namespace saccade {

std::optional<LoopGaze> make_gaze(const Scenario& scenario, const JointLimits& limits) {
  const GazeControllerConfig& config = scenario.gaze.controller;
  if (scenario.gaze.detector == "none" && config.controller != "script") return std::nullopt;
  LoopGaze gaze{
      {},
      make_gate(scenario.gaze.gate),
      LoopMotion{make_gaze_controller(config, limits), JointLimiter(motion_limits(limits, config.limits))},
      scenario.gaze.follow};
  for (std::size_t i = 0; i < scenario.detectors.size(); ++i) {
    const auto& [name, detector] = scenario.detectors[i];
    if (name != scenario.gaze.detector) continue;
    gaze.driver = i;
    if (scenario.sim.both_eyes() && scenario.gaze.stereo) {
      const MountedCamera& right = scenario.right_calibration;
      gaze.stereo.emplace(
          LoopStereo{make_detector(detector, right.camera), right, StereoLocator(scenario.gaze.gate.target)});
    }
  }
  return gaze;
}

std::vector<LoopDetector> make_detectors(const NamedDetectors& named, const Camera& camera) {
  std::vector<LoopDetector> detectors;
  for (const auto& [name, config] : named) detectors.push_back({name, make_detector(config, camera)});
  return detectors;
}

}  // namespace saccade
