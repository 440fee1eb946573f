#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "apps/view/checkpoints.h"
#include "apps/view/detector_change.h"
#include "apps/view/memory_reader.h"
#include "apps/view/playback.h"
#include "apps/view/recorded_detector.h"
#include "apps/view/recorded_truth.h"
#include "config/scenario.h"
#include "head/icub_cameras.h"
#include "session/scenario_loop.h"
#include "session/session.h"
#include "sim/lab.h"

namespace saccade {
namespace {

/// A seek over more time than this takes the estimates that a run recorded, instead of processing the events between.
constexpr std::int64_t longest_processed_us = 1'000'000;

/// The world of a run folder; null where its scenario is missing or of another version.
std::unique_ptr<World> world_of(const std::filesystem::path& folder, const Registry& registry) {
  if (!std::filesystem::exists(folder / "scenario.yaml")) return nullptr;
  try {
    const Scenario scenario = read_scenario(folder / "scenario.yaml", {}, std::nullopt, registry);
    const auto seed = static_cast<std::uint64_t>(scenario.seed);
    const Lab lab(scenario.sim.lab, seed);
    auto world = std::make_unique<World>(scenario.sim.world, lab.mjcf(), seed);
    lab.paint(world->model());
    return world;
  } catch (const InputError&) {
    return nullptr;
  }
}

/// The detectors of a run folder as YAML; empty where its file is missing or of another version.
std::string detectors_of(const std::filesystem::path& folder, const Registry& registry) {
  try {
    const auto recorded = read_recorded_detectors(folder, {}, registry.detectors);
    return recorded ? resolved_detectors(recorded->detectors) : std::string();
  } catch (const InputError&) {
    return {};
  }
}

class RecordingPlayback final : public Playback, private LoopObserver {
 public:
  RecordingPlayback(const ReadOptions& options, const std::filesystem::path& truth,
                    const NamedDetectors& detectors, const std::string& selected, const Registry& registry)
      : settings_(view_settings(detectors, selected)) {
    ReplaySource source = open_replay_source(options, truth);
    eye_ = source.eye;
    camera_ = source.camera;
    std::int64_t start_us = 0;
    {
      ReplayRobot robot(open_event_file(options.formats, source.events, source.read), std::move(source.head));
      start_us = robot.now_us();
      camera_.camera.size = robot.image_size();
      has_head_ = robot.head() != nullptr;
      if (has_head_) start_us -= tick_us;  // the first row is of a run's first tick
      for (std::int64_t t_us = robot.now_us(); robot.wait_until(t_us) == PortStatus::ok; t_us += 100'000) {
        if (robot.read_until(t_us, events_) == PortStatus::ended) break;
      }
    }
    if (events_.empty()) {
      throw InputError(options.recording.string(), "no events of the chosen eye",
                       "a recording with events; saccade info lists what it holds");
    }
    truth_ = RecordedTruth(std::move(source.truth), source.chances == Chances::annotated, camera_.camera);
    std::int64_t last_us = events_.back().t_us;
    if (is_run_folder(options)) {
      folder_ = options.recording;
      if (eye_ == Eye::left) truth_.read_gaze(folder_);
      last_us = std::max(last_us, truth_.last_us().value_or(last_us));
      if (has_head_) world_ = world_of(folder_, registry);
      if (world_) model_ = {world_, &world_->model()};
      if (truth_.last_us()) {  // a run with its gaze, which has a row of detections for every observation
        run_detectors_ = detectors_of(folder_, registry);
        if (!run_detectors_.empty()) estimates_ = read_estimates(folder_);
      }
    }
    const std::int64_t ticks = std::max<std::int64_t>(1, (last_us - start_us + tick_us - 1) / tick_us);
    history_ = LoopHistory(camera_.camera, eye_, start_us, start_us + ticks * tick_us);
    checkpoints_.emplace(history_);
    restore(checkpoints_->start());
  }

  [[nodiscard]] const LoopHistory& history() const override { return history_; }

  bool tick() override {
    const std::int64_t t_us = history_.now_us() + tick_us;
    if (t_us > history_.end_us()) return false;
    session_->tick(t_us);
    if (history_.now_us() != t_us) return false;
    if (reproducible_ && t_us >= whole_from_us_ && checkpoints_->due(t_us))
      checkpoints_->add(history_, loop_->detectors());
    return true;
  }

  void restore_before(std::int64_t t_us) override {
    const Checkpoint& best = checkpoints_->latest_before(t_us);
    const bool goes_on = history_.now_us() < t_us && history_.now_us() >= best.history.now_us();
    const std::int64_t from_us = goes_on ? history_.now_us() : best.history.now_us();
    if (t_us - from_us > longest_processed_us && jump_before(t_us)) return;
    if (!goes_on) restore(best);
  }

  void apply(const ViewSettings& settings) override {
    ChangedDetectors changed = change_detectors(settings, settings_, *loop_, history_, camera_, eye_);
    loop_->set_detectors(std::move(changed.detectors), std::nullopt);
    history_.replace_outputs(std::move(changed.outputs), settings.selected_in_loop());
    const bool same_detectors =
        resolved_detectors(settings.enabled()) == resolved_detectors(settings_.enabled());
    settings_ = settings;
    if (same_detectors) return;
    checkpoints_->clear();
    reproducible_ = false;
  }

  void fill(Snapshot& snapshot) override {
    history_.fill(snapshot, *loop_);
    snapshot.grey.clear();
    if (!world_) return;
    snapshot.use_model(model_);
    JointVector joints = JointVector::Zero();
    if (!history_.inputs().empty() && history_.inputs().back()->head)
      joints = history_.inputs().back()->head->position_rad;
    world_->pose(history_.now_us(), joints, *snapshot.scene);
  }

  [[nodiscard]] const ViewSettings& settings() const override { return settings_; }
  [[nodiscard]] std::vector<float> event_counts() const override {
    std::vector<float> parts(600, 0.0F);
    const auto start_us = static_cast<double>(history_.start_us());
    const double span_us = static_cast<double>(history_.end_us()) - start_us;
    for (const Event& event : events_) {
      const double share = (static_cast<double>(event.t_us) - start_us) / span_us;
      const auto part = static_cast<std::size_t>(share * static_cast<double>(parts.size()));
      parts[std::min(part, parts.size() - 1)] += 1.0F;
    }
    return parts;
  }

 private:
  void on_tick(const Tick& tick) override {
    history_.record(tick, truth_.at(tick.t_us), *loop_, settings_.selected_in_loop());
  }

  void restore(const Checkpoint& checkpoint) {
    std::vector<LoopDetector> detectors = copies(checkpoint.detectors);
    if (detectors.empty()) detectors = new_detectors(checkpoint.history.now_us());
    start_from(checkpoint.history, std::move(detectors));
    whole_from_us_ = history_.now_us();
  }

  /// Whether the detectors are those of the run, whose estimates are recorded, and can be copied.
  [[nodiscard]] bool shows_recorded(std::span<const LoopDetector> detectors) const {
    return !estimates_.empty() && resolved_detectors(settings_.enabled()) == run_detectors_ &&
           std::ranges::all_of(
               detectors, [](const LoopDetector& detector) { return can_be_copied(*detector.detector); });
  }

  /// New detectors of the settings; with the estimates that the run recorded, where they are the run's. Those get the events
  /// from `from_us` on for their Hough spaces.
  [[nodiscard]] std::vector<LoopDetector> new_detectors(std::int64_t from_us) const {
    std::vector<LoopDetector> detectors = make_detectors(settings_.enabled(), camera_.camera);
    if (!shows_recorded(detectors)) return detectors;
    for (LoopDetector& detector : detectors) {
      const auto estimates = estimates_.find(detector.name);
      detector.detector = std::make_unique<RecordedDetector>(
          estimates != estimates_.end() ? estimates->second : nullptr, std::move(detector.detector), from_us);
    }
    return detectors;
  }

  /// Goes to where ticking on to t_us fills the plots, with the estimates that the run recorded; the detectors get the last
  /// events alone. False, and nothing happens, where the estimates are not of the run.
  bool jump_before(std::int64_t t_us) {
    if (!shows_recorded(loop_->detectors())) return false;
    // Earlier by a checkpoint's spacing than a detector that is added: steps back begin there.
    const std::int64_t whole_from_us = t_us - Checkpoints::first_spacing_us;
    LoopHistory history = checkpoints_->start().history;
    history.begin_at(std::max(history.start_us(), t_us - Snapshot::plot_us));
    start_from(history, new_detectors(whole_from_us - Snapshot::events_us));
    whole_from_us_ = whole_from_us;
    return true;
  }

  void start_from(const LoopHistory& history, std::vector<LoopDetector> detectors) {
    std::optional<RecordedHead> head;
    if (has_head_) head = recorded_head(folder_);
    session_.reset();
    loop_.reset();
    history_ = history;
    const std::int64_t now_us = history_.now_us();
    const auto next = now_us == history_.start_us()
                          ? events_.begin()
                          : std::ranges::upper_bound(events_, now_us, {}, &Event::t_us);
    robot_ = std::make_unique<ReplayRobot>(
        std::make_unique<MemoryReader>(std::span<const Event>(next, events_.end()), camera_.camera.size),
        std::move(head));
    robot_->wait_until(now_us);
    loop_.emplace(*robot_, camera_, std::move(detectors), std::nullopt, eye_);
    session_.emplace(*robot_, *loop_).add_observer(*this);
    reproducible_ = true;
  }

  ViewSettings settings_;
  std::filesystem::path folder_;  // of a run; empty for a bare recording
  Eye eye_ = Eye::left;
  MountedCamera camera_;
  bool has_head_ = false;
  std::vector<Event> events_;
  RecordedTruth truth_;
  std::shared_ptr<World> world_;
  std::shared_ptr<const mjModel> model_;  // of world_
  LoopHistory history_{icub_left_2016, Eye::left, 0, 0};
  std::optional<Checkpoints> checkpoints_;
  std::string run_detectors_;                                                  // of the run, as YAML
  std::map<std::string, std::shared_ptr<const RecordedEstimates>> estimates_;  // of the run
  std::int64_t whole_from_us_ =
      0;  // from here on the detectors have processed the events that their Hough spaces need
  bool reproducible_ = true;  // the detectors are in the state that a run from the start leads to
  std::unique_ptr<ReplayRobot> robot_;
  std::optional<Loop> loop_;
  std::optional<Session> session_;
};

}  // namespace

std::unique_ptr<Playback> make_recording_playback(const ReadOptions& options,
                                                  const std::filesystem::path& truth,
                                                  const NamedDetectors& detectors,
                                                  const std::string& selected, const Registry& registry) {
  return std::make_unique<RecordingPlayback>(options, truth, detectors, selected, registry);
}

}  // namespace saccade
