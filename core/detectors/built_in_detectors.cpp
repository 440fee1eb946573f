#include "core/detectors/built_in_detectors.h"

#include "core/baselines/blob_filter.h"
#include "core/baselines/cluster.h"
#include "core/baselines/eros.h"
#include "core/baselines/multi_kernel.h"
#include "core/baselines/original_2016.h"
#include "core/baselines/particle_filter.h"
#include "core/baselines/scarf.h"
#include "core/hough/hough_detector.h"
#include "core/tracker/ball_tracker.h"

namespace saccade {

namespace {

HoughDetectorConfig hough(bool directed, double threshold) {
  HoughDetectorConfig config;
  config.directed = directed;
  config.threshold = threshold;
  return config;
}

DetectorRow hough_row(std::string name, std::string description, const HoughDetectorConfig& defaults) {
  return detector_row(std::move(name), std::move(description), defaults,
                      [](const HoughDetectorConfig& config, const Camera& camera) {
                        return std::make_unique<HoughDetector>(config, camera.size);
                      });
}

}  // namespace

DetectorRegistry built_in_detectors() {
  HoughDetectorConfig lifetime = hough(true, 0.6);
  lifetime.window = event_window(WindowKind::lifetime);
  HoughDetectorConfig single_radius = hough(false, 1.0);
  single_radius.single_radius = true;

  DetectorRegistry registry;
  registry.add(hough_row("paper_full", "circular Hough transform of the paper, a ring of votes per event",
                         hough(false, 1.0)));
  registry.add(hough_row("paper_directed",
                         "directed Hough transform of the paper, arcs along the event's flow",
                         hough(true, 0.3)));
  registry.add(detector_row("best", "tracker of up to eight circles through edges; the detector to use",
                            BallTrackerConfig{}, make_ball_tracker));
  registry.add(hough_row("lifetime", "directed Hough transform with a window by the lifetime of each event",
                         lifetime));
  registry.add(hough_row("single_radius", "circular Hough transform for one radius", single_radius));
  registry.add(detector_row("original_2016",
                            "directed Hough transform as the event-driven project had it in 2016",
                            Original2016Config{}, [](const Original2016Config& config, const Camera& camera) {
                              return std::make_unique<Original2016>(config, camera.size);
                            }));
  registry.add(detector_row("cluster", "circular clusters of events", ClusterConfig{},
                            [](const ClusterConfig& config, const Camera& camera) {
                              return std::make_unique<ClusterDetector>(config, camera.size);
                            }));
  registry.add(detector_row("multi_kernel", "multi-kernel tracker with rings as kernels", MultiKernelConfig{},
                            [](const MultiKernelConfig& config, const Camera& camera) {
                              return std::make_unique<MultiKernelDetector>(config, camera.size);
                            }));
  registry.add(detector_row("eros", "convolution kernels on an exponential reduced ordinal surface",
                            ErosConfig{}, [](const ErosConfig& config, const Camera& camera) {
                              return std::make_unique<ErosDetector>(config, camera.size);
                            }));
  registry.add(detector_row("scarf", "convolution kernels on a set of centre active receptive fields",
                            ScarfConfig{}, [](const ScarfConfig& config, const Camera& camera) {
                              return std::make_unique<ScarfDetector>(config, camera.size);
                            }));
  registry.add(detector_row("particle_filter", "particle filter of circles", ParticleFilterConfig{},
                            [](const ParticleFilterConfig& config, const Camera& camera) {
                              return std::make_unique<ParticleFilter>(config, camera.size);
                            }));
  registry.add(detector_row("blob_filter", "Kalman filters of blobs of events", BlobFilterConfig{},
                            [](const BlobFilterConfig& config, const Camera& camera) {
                              return std::make_unique<BlobFilter>(config, camera.size);
                            }));
  registry.defaults = {"paper_full", "paper_directed", "best"};
  return registry;
}

}  // namespace saccade
