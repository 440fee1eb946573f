#include "apps/view/detector_change.h"

#include <algorithm>

#include "core/detector_views.h"
#include "core/error.h"

namespace saccade {
namespace {

bool same_config(const DetectorConfig& a, const DetectorConfig& b) {
  return resolved_detectors({{"", a}}) == resolved_detectors({{"", b}});
}

/// Processes the inputs of the history.
DetectorOutput warm_up(const std::string& name, Detector& detector, const LoopHistory& history,
                       const HeadChain& chain, const MountedCamera& camera, Eye eye) {
  DetectorOutput output{name, {}, detector.threshold()};
  for (const auto& input : history.inputs()) {
    std::optional<CameraMotion> motion;
    if (input->head && is_finite(*input->head))
      motion = camera_motion(chain, *input->head, eye, camera.mount.eye_from_camera());
    detector.process(input->events, motion ? &*motion : nullptr);
    detector.advance_to(input->t_us, motion ? &*motion : nullptr);
    output.tick.estimate = detector.estimate();
    output.tick.observe(!input->events.empty(), output.threshold);
  }
  return output;
}

}  // namespace

std::vector<LoopDetector> copies(std::span<const LoopDetector> detectors) {
  std::vector<LoopDetector> copied;
  const auto copyable = [](const LoopDetector& detector) { return can_be_copied(*detector.detector); };
  if (!std::ranges::all_of(detectors, copyable)) return copied;
  for (const LoopDetector& detector : detectors)
    copied.push_back({detector.name, copy_of(*detector.detector)});
  return copied;
}

ChangedDetectors change_detectors(const ViewSettings& settings, const ViewSettings& before, const Loop& loop,
                                  const LoopHistory& history, const MountedCamera& camera, Eye eye) {
  ChangedDetectors changed;
  for (const ViewDetector& wanted : settings.detectors) {
    if (!wanted.enabled) continue;
    const auto has_name = [&](const auto& other) { return other.name == wanted.name; };
    const bool unchanged = std::ranges::any_of(before.detectors, [&](const ViewDetector& other) {
      return other.enabled && has_name(other) && same_config(other.config, wanted.config);
    });
    const auto it = std::ranges::find_if(loop.detectors(), has_name);
    SACCADE_CHECK(!unchanged || it != loop.detectors().end());
    if (std::unique_ptr<Detector> copy = unchanged ? copy_of(*it->detector) : nullptr) {
      changed.detectors.push_back({wanted.name, std::move(copy)});
      const auto output = std::ranges::find_if(history.outputs(), has_name);
      changed.outputs.push_back(output != history.outputs().end()
                                    ? *output
                                    : DetectorOutput{wanted.name, {}, it->detector->threshold()});
      continue;
    }
    auto detector = make_detector(wanted.config, camera.camera);
    changed.outputs.push_back(warm_up(wanted.name, *detector, history, loop.head()->chain, camera, eye));
    changed.detectors.push_back({wanted.name, std::move(detector)});
  }
  return changed;
}

}  // namespace saccade
