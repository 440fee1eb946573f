#include "session/recovered_run.h"

#include <algorithm>
#include <limits>

#include "config/robot_file.h"
#include "config/scenario.h"
#include "core/error.h"
#include "evaluation/report/report.h"
#include "evaluation/scoring/metrics.h"
#include "recording/event_file.h"
#include "recording/run_file_names.h"
#include "session/run_tables.h"
#include "session/scenario_loop.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;

struct RecoveredEvents {
  std::int64_t count = 0;
  std::int64_t right_count = 0;  ///< of them, the right eye's
  std::int64_t first_us = std::numeric_limits<std::int64_t>::max();
  std::int64_t last_us = std::numeric_limits<std::int64_t>::min();
};

RecoveredEvents recovered_events(const FormatRegistry& formats, const fs::path& file) {
  constexpr std::size_t block_events = 1 << 16;
  RecoveredEvents events;
  if (!fs::exists(file)) return events;
  const auto reader = open_event_file(formats, file);
  std::vector<Event> block;
  for (; reader->read(block, block_events) > 0; block.clear()) {
    for (const Event& event : block) {
      ++events.count;
      events.right_count += event.camera == 1 ? 1 : 0;
      events.first_us = std::min(events.first_us, event.t_us);
      events.last_us = std::max(events.last_us, event.t_us);
    }
  }
  return events;
}

template <class Row>
std::vector<Row> recovered_rows(const fs::path& table) {
  return fs::exists(table) ? read_table<Row>(table) : std::vector<Row>{};
}

/// What the configuration in the folder says of the run.
struct RecoveredRun {
  Metrics metrics;
  NamedDetectors detectors;
};

RecoveredRun recovered_run(const Scenario& scenario) {
  RecoveredRun run;
  run.metrics.scenario = scenario.name;
  run.metrics.seed = scenario.seed;
  run.metrics.events_file = event_file_name(scenario);
  run.metrics.camera = scenario.sim.camera;
  run.metrics.calibration = scenario.calibration;
  if (scenario.sim.both_eyes()) {
    RightEyeMetrics& right = run.metrics.right_eye.emplace();
    right.camera = scenario.sim.right.camera;
    right.calibration = scenario.right_calibration;
  }
  run.detectors = scenario.detectors;
  return run;
}

RecoveredRun recovered_run(const RobotFile& robot) {
  RecoveredRun run;
  run.metrics.scenario = robot.name;
  run.metrics.events_file = run_file::events(robot.output.events);
  run.metrics.camera = robot.calibration.camera;
  run.metrics.calibration = robot.calibration;
  run.detectors = robot.detectors;
  return run;
}

/// NaN where the detector, such as a program of its own, cannot be made.
double recovered_threshold(const std::pair<std::string, DetectorConfig>& named, const Camera& camera) {
  try {
    return make_detectors({named}, camera).front().detector->threshold();
  } catch (const std::runtime_error&) {
    return std::numeric_limits<double>::quiet_NaN();
  }
}

}  // namespace

bool complete_run_folder(const fs::path& folder, const Registry& registry) {
  if (fs::exists(folder / run_file::metrics)) return false;
  RecoveredRun run;
  if (fs::exists(folder / run_file::scenario)) {
    run = recovered_run(read_scenario(folder / run_file::scenario, {}, std::nullopt, registry));
  } else if (fs::exists(folder / run_file::robot)) {
    run = recovered_run(read_robot_file(folder / run_file::robot, {}, registry));
  } else {
    return false;
  }
  Metrics& metrics = run.metrics;
  auto truth = recovered_rows<TruthRow>(folder / run_file::truth);
  const auto detections = recovered_rows<DetectionRow>(folder / run_file::detections);
  const RecoveredEvents events = recovered_events(registry.formats, folder / metrics.events_file);
  if (truth.empty() && detections.empty() && events.count == 0) return false;

  metrics.interrupted = true;
  metrics.image = metrics.calibration->camera.size;
  metrics.event_count = events.count;
  if (metrics.right_eye) metrics.right_eye->event_count = events.right_count;
  std::int64_t end_us = events.count > 0 ? events.last_us : 0;
  if (!metrics.seed && events.count > 0) metrics.start_us = events.first_us;  // a simulation starts at 0
  if (!detections.empty()) end_us = std::max(end_us, detections.back().t_us);
  if (!truth.empty()) end_us = std::max(end_us, truth.back().t_us);
  metrics.duration_s = static_cast<double>(end_us - metrics.start_us) * 1e-6;
  // Each table ends where its last block of bytes was written.
  if (!detections.empty()) {
    std::erase_if(truth, [&](const TruthRow& row) { return row.t_us > detections.back().t_us; });
  }
  for (const auto& named : run.detectors) {
    const auto& [name, config] = named;
    const double threshold = recovered_threshold(named, metrics.calibration->camera);
    DetectorScore score;
    score.threshold = threshold;
    if (!truth.empty()) {
      score = score_detector(truth, detections, name, threshold, Chances::simulated);
    } else {
      score.observations = std::ranges::count_if(detections, [&, &name = name](const DetectionRow& row) {
        return row.detector == name && row.score >= threshold;
      });
    }
    metrics.detectors.emplace_back(name, std::move(score));
  }
  write_metrics(folder / run_file::metrics, metrics);
  write_figures(folder / run_file::figures_json, metrics);
  write_report(folder, registry.formats);
  return true;
}

}  // namespace saccade
