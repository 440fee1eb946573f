#include "core/detector_registry.h"

#include "core/ball_tracker.h"
#include "core/baselines/blob_filter.h"
#include "core/baselines/cluster.h"
#include "core/baselines/eros.h"
#include "core/baselines/multi_kernel.h"
#include "core/baselines/original_2016.h"
#include "core/baselines/particle_filter.h"
#include "core/baselines/scarf.h"
#include "core/hough_detector.h"

namespace saccade::inline v0_1 {

DetectorConfig::DetectorConfig(NamedRows<DetectorRow> rows, std::string preset)
    : rows_(std::move(rows)), preset_(std::move(preset)), config_(row().config) {}

const DetectorRow& DetectorConfig::row() const {
  const DetectorRow* const row = rows_.find(preset_);
  SACCADE_CHECK(row != nullptr);
  return *row;
}

const std::string& DetectorConfig::preset() const { return preset_; }

std::string DetectorConfig::window() const {
  const DetectorRow& r = row();
  return r.window ? r.window(config_) : std::string{};
}

bool DetectorConfig::scale_threshold(double factor) {
  if (row().threshold == nullptr) return false;
  AnyConfig scaled = config_;
  *row().threshold(scaled) *= factor;
  FieldChecker checker("detector");
  describe(checker, scaled);
  if (checker.passed()) config_ = std::move(scaled);
  return checker.passed();
}

void describe(FieldVisitor& v, DetectorConfig& config) {
  std::string preset = config.preset_;
  v.choice("preset", preset, config.rows_.names(),
           "detector whose values are the defaults of the other keys");
  if (preset != config.preset_ && config.rows_.find(preset) != nullptr) {
    config = DetectorConfig(config.rows_, preset);
  }
  describe(v, config.config_);
}

std::unique_ptr<Detector> make_detector(const DetectorConfig& config, const Camera& camera) {
  return config.row().make(config.config_, camera);
}

void DetectorRegistry::add(DetectorRow row) {
  if (row.name == "none")
    throw InputError("name of a row", row.name, "another name: this one stands for no detector");
  rows_.add(std::move(row));
}

DetectorConfig DetectorRegistry::config(const std::string& name) const {
  if (!has(name)) throw InputError("detector preset", name, expectation_of(names()));
  return {rows_, name};
}

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

}  // namespace saccade::inline v0_1
