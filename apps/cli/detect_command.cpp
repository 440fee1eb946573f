#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <memory>

#include "apps/cli/commands.h"
#include "apps/cli/read_options.h"
#include "apps/config/scenario.h"
#include "apps/session/interrupt.h"
#include "apps/session/played.h"
#include "apps/session/run_folder.h"
#include "apps/session/summary.h"
#include "core/error.h"
#include "evaluation/report/report.h"
#include "loop/loop.h"
#include "robot/replay/replay_robot.h"

namespace saccade {
namespace {

constexpr std::int64_t tick_us = 1'000;
/// How long before an annotated instant an event makes an observation of it (design.md section 7).
constexpr std::int64_t sparse_window_us = 10'000;

struct DetectOptions : ReadOptions {
  std::filesystem::path config, truth, out;
  std::vector<std::string> assignments;
  bool force = false;
};

/// Keeps what the detectors say at the instants that are scored.
class DetectionRecorder final : public LoopObserver {
 public:
  explicit DetectionRecorder(const Loop& loop) : loop_(loop), elapsed_ns_(loop.detectors().size(), 0) {}

  void on_tick(const Tick& tick) override {
    event_count_ += static_cast<std::int64_t>(tick.events.size());
    for (std::size_t i = 0; i < tick.detectors.size(); ++i) {
      const DetectorTick& seen = tick.detectors[i];
      elapsed_ns_[i] += seen.elapsed_ns;
      if (!scored_ || !seen.observed) continue;
      rows_.push_back({tick.t_us, loop_.detectors()[i].name, seen.estimate.circle, seen.estimate.score,
                       seen.estimate.held});
    }
  }
  void score_next(bool scored) { scored_ = scored; }

  [[nodiscard]] const std::vector<DetectionRow>& rows() const { return rows_; }
  [[nodiscard]] std::int64_t event_count() const { return event_count_; }
  [[nodiscard]] std::int64_t elapsed_ns(std::size_t detector) const { return elapsed_ns_[detector]; }

 private:
  const Loop& loop_;
  bool scored_ = true;
  std::vector<DetectionRow> rows_;
  std::vector<std::int64_t> elapsed_ns_;
  std::int64_t event_count_ = 0;
};

/// Plays the whole recording, tick by tick; with annotated truth the ticks are the instants themselves and
/// the starts of the windows in which an event makes an observation of them.
void play(ReplayRobot& robot, Loop& loop, DetectionRecorder& recorder, std::span<const TruthRow> truth) {
  if (truth.empty()) {
    for (std::int64_t t_us = robot.now_us() + tick_us; !interrupted(); t_us += tick_us) {
      if (loop.tick(t_us, recorder) != PortStatus::ok) return;
    }
    return;
  }
  std::int64_t last_us = robot.now_us();
  for (const TruthRow& row : truth) {
    if (interrupted()) return;
    for (const bool scored : {false, true}) {
      const std::int64_t t_us = scored ? row.t_us : row.t_us - sparse_window_us;
      if (t_us <= last_us) continue;
      recorder.score_next(scored);
      loop.tick(t_us, recorder);
      last_us = t_us;
    }
  }
}

int detect(const DetectOptions& options, const Registry& registry) {
  const NamedDetectors named = read_detectors(options.config, options.assignments, registry.detectors);
  Played played = open_played(options, options.truth);
  const std::vector<TruthRow>& truth = played.truth;
  const bool annotated = !truth.empty() && played.chances == Chances::annotated;
  const EventReadOptions& read = played.read;
  ReplayRobot robot(open_event_file(played.events, read), std::move(played.head));
  MountedCamera camera = played.camera;
  camera.camera.size = robot.image_size();

  std::vector<LoopDetector> detectors;
  for (const auto& [name, config] : named) detectors.push_back({name, make_detector(config, camera.camera)});
  Loop loop(robot, camera, std::move(detectors), std::nullopt, played.eye);
  DetectionRecorder recorder(loop);
  if (!options.out.empty()) prepare_run_folder(options.out, options.force);

  catch_interrupts();
  const std::int64_t start_us = robot.now_us();
  const auto begin = std::chrono::steady_clock::now();
  play(robot, loop, recorder, annotated ? truth : std::vector<TruthRow>{});
  const double wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  const RejectedEvents rejected = robot.rejected();
  if (recorder.event_count() + rejected.back_in_time + rejected.outside_image == 0 && !interrupted()) {
    throw InputError(options.recording.string(), "no events of a camera",
                     "a recording with some; saccade info tells what it holds");
  }

  Metrics metrics;
  metrics.scenario = options.recording.filename().string();
  if (robot.head() != nullptr) {
    metrics.camera = camera.camera;
    metrics.calibration = camera;
  }
  metrics.start_us = start_us;
  metrics.duration_s = static_cast<double>(robot.now_us() - start_us) * 1e-6;
  metrics.wall_s = wall_s;
  metrics.event_count = recorder.event_count();
  metrics.events_file = std::filesystem::absolute(played.events).string();
  metrics.events_camera = read.camera;
  metrics.image = camera.camera.size;
  for (std::size_t i = 0; i < named.size(); ++i) {
    DetectorScore score = score_detector(truth, recorder.rows(), named[i].first,
                                         loop.detectors()[i].detector->threshold(), played.chances);
    if (truth.empty()) {
      score.observations = std::ranges::count_if(recorder.rows(), [&](const DetectionRow& row) {
        return row.detector == named[i].first && row.score >= score.threshold;
      });
    }
    if (recorder.event_count() > 0) {
      score.us_per_event =
          static_cast<double>(recorder.elapsed_ns(i)) * 1e-3 / static_cast<double>(recorder.event_count());
    }
    score.rejected_events = loop.detectors()[i].detector->rejected();
    metrics.detectors.emplace_back(named[i].first, std::move(score));
  }
  print_summary(metrics);
  if (rejected.back_in_time + rejected.outside_image > 0) {
    fmt::print(stderr, "saccade: {}: left out {} events that go back in time and {} outside the image\n",
               options.recording.string(), rejected.back_in_time, rejected.outside_image);
  }
  if (!options.out.empty()) {
    OutputFile resolved(options.out / "detectors.yaml");
    resolved.write(resolved_detectors(named));
    resolved.commit();
    TableWriter<DetectionRow> table(options.out / "detections.csv");
    for (const DetectionRow& row : recorder.rows()) table.write(row);
    table.commit();
    if (!truth.empty()) {
      TableWriter<TruthRow> truth_table(options.out / "truth.csv");
      for (const TruthRow& row : truth) truth_table.write(row);
      truth_table.commit();
    }
    write_metrics(options.out / "metrics.json", metrics);
    write_report(options.out);
    fmt::print("{}\n", (options.out / "report.html").string());
  }
  if (interrupted()) throw RunError("interrupted; what was found until then is scored");
  return 0;
}

}  // namespace

void add_detect_command(CommandLine& line, const Registry& registry) {
  auto options = std::make_shared<DetectOptions>();
  Command command =
      line.add_command("detect", "The detectors on recorded events, scored when truth is given");
  add_read_options(command, "recording", "Event file, or a run folder with its joints and truth", *options);
  command.option("--config", options->config, "Detectors (YAML); those of the paper and `best` by default");
  command
      .option("--set", options->assignments,
              "key=value for every detector, DETECTOR.key=value for one; e.g. radius_px=[4,25]")
      .one_value_each();
  command.option("--truth", options->truth, "True circles, t_us,x_px,y_px,r_px (CSV)");
  command.option("--out", options->out, "Folder for detections, scores and report");
  command.flag("--force", options->force, "Replace an earlier run in that folder");
  command.action([options, &registry] { return detect(*options, registry); });
}

}  // namespace saccade
