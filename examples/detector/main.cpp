// The program `saccade` with one more detector, `centroid`.
#include "apps/cli/program.h"
#include "centroid_detector.h"

int main(int argc, char** argv) {
  saccade::Registry registry = saccade::built_in_registry();
  registry.detectors.add(
      saccade::detector_row("centroid", "centroid of the newest events", example::CentroidConfig{},
                            [](const example::CentroidConfig& config, const saccade::Camera& camera) {
                              return std::make_unique<example::CentroidDetector>(config, camera.size);
                            }));
  return saccade::program(argc, argv, registry);
}
