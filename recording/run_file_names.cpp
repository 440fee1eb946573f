#include "recording/run_file_names.h"

#include "recording/format_registry.h"

namespace saccade {

std::vector<std::string> run_file_names(const FormatRegistry& formats) {
  using namespace run_file;
  std::vector<std::string> names = {scenario,
                                    detectors,
                                    robot,
                                    joints,
                                    truth,
                                    truth_right,
                                    detections,
                                    detections_right,
                                    gaze,
                                    eye,
                                    labels,
                                    labels_right,
                                    timing,
                                    metrics,
                                    deploy,
                                    serve,
                                    report,
                                    video,
                                    video_part,
                                    log,
                                    frames,
                                    figures,
                                    streaming,
                                    figures_json,
                                    target,
                                    imu,
                                    scene,
                                    replay,
                                    ground_truth_hdf5,
                                    ground_truth_npz};
  for (const std::string& choice : formats.run_choices()) {
    for (const auto& file : formats.files_of(events(choice))) names.push_back(file.string());
  }
  return names;
}

}  // namespace saccade
