#include "apps/deploy/deploy_recorder.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <chrono>
#include <limits>
#include <nlohmann/json.hpp>

#include "control/head_kinematics.h"
#include "core/error.h"
#include "evaluation/scoring/metrics.h"

namespace saccade {
namespace {

constexpr std::size_t tick_slots = 4096;
constexpr std::size_t event_slots = std::size_t{1} << 19;
constexpr std::chrono::milliseconds pause(5);
constexpr std::int64_t timing_us = 100'000;
constexpr std::int64_t table_sync_us = 1'000'000;
constexpr std::int64_t terminal_status_us = 200'000;
constexpr std::int64_t log_status_us = 1'000'000;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

double ms(std::int64_t us) { return static_cast<double>(us) * 1e-3; }

double mean(std::int64_t sum, std::int64_t count) {
  return count > 0 ? static_cast<double>(sum) / static_cast<double>(count) : nan;
}

std::size_t terminal_width() {
  winsize size{};
  return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 1 ? size.ws_col - 1U : 79U;
}

std::string text_of_change(const DeployChange& change) {
  if (!change.rejected.empty()) return "not activated: " + change.rejected;
  if (change.stop) {
    return fmt::format("stopped: {}; stop command after {:.1f} ms", change.stop->description(),
                       ms(change.took_us));
  }
  return std::string(name_of(change.state)) + (change.warning.empty() ? "" : "; warning: " + change.warning);
}

nlohmann::json json_of(const TimeFigures& figures) {
  if (figures.count() == 0) return {{"p50", nullptr}, {"p99", nullptr}, {"max", nullptr}};
  return {{"p50", figures.quantile_us(0.5)}, {"p99", figures.quantile_us(0.99)}, {"max", figures.max_us()}};
}

/// The bins that are not empty, [us, count].
nlohmann::json json_of(const MicrosecondHistogram& histogram) {
  nlohmann::json bins = nlohmann::json::array();
  for (std::int64_t us = 0; us <= MicrosecondHistogram::longest_us; ++us) {
    if (histogram.count(us) > 0) bins.push_back({us, histogram.count(us)});
  }
  return {{"bin_us", 1}, {"bins", std::move(bins)}, {"longer", histogram.over()}};
}

}  // namespace

void DeployRecorder::Figures::add(const Slot& slot) {
  const TickTiming& timing = slot.timing;
  late.add(timing.begin_us - timing.due_us);
  tick.add(timing.end_us - timing.begin_us);
  tick_sum_us += timing.end_us - timing.begin_us;
  if (timing.latency_us) {
    latency.add(*timing.latency_us);
    latency_sum_us += *timing.latency_us;
  }
  missed += timing.missed;
  events += static_cast<std::int64_t>(slot.tick.events.size());
  left_out += static_cast<std::int64_t>(slot.tick.events_left_out);
  for (const DetectorTick& detector : slot.detectors) skipped += detector.skipped ? 1 : 0;
}

DeployRecorder::DeployRecorder(std::filesystem::path folder, const RobotFile& robot, const Loop& loop,
                               ImageSize image, DeployFacts facts)
    : folder_(std::move(folder)),
      robot_(robot),
      loop_(loop),
      image_(image),
      facts_(std::move(facts)),
      ticks_(tick_slots, Slot{{}, {}, std::vector<DetectorTick>(loop.detectors().size()), 0}),
      event_ring_(event_slots),
      failures_(loop,
                [this](std::int64_t t_us, const std::string& what, const std::string& why) {
                  ended_.push_back({t_us, what, why});
                  on_news(t_us, what + ": " + why);
                }),
      terminal_(isatty(STDERR_FILENO) != 0),
      log_file_(folder_ / "log.txt", [this](const std::string& line) { print_line(line); }),
      log_([this](std::int64_t t_us, const std::string& text) { log_file_.write(t_us, text); }),
      observations_(loop),
      detections_(folder_ / "detections.csv"),
      gaze_(folder_ / "gaze.csv", loop.head()),
      timing_(folder_ / "timing.csv"),
      black_box_(folder_ / "blackbox", loop.head()),
      detectors_(loop.detectors().size()),
      last_joints_us_(std::numeric_limits<std::int64_t>::min()) {
  if (facts_.record) {
    recording_.emplace(folder_, robot.output.formats, image_,
                       RecordingFilesConfig{robot.output.events, robot.output.rotate_mb * 1'000'000,
                                            std::llround(robot.output.rotate_s * 1e6),
                                            robot.output.least_free_mb * 1'000'000, loop.head()});
  }
  writer_ = std::thread([this] { work(); });
}

DeployRecorder::~DeployRecorder() {
  over_ = true;
  if (writer_.joinable()) writer_.join();
}

void DeployRecorder::on_tick(const Tick& tick, const TickTiming& timing) {
  failures_.on_tick(tick);
  Slot* const slot = ticks_.claim();
  if (slot == nullptr) {
    lost_ticks_.fetch_add(1, std::memory_order_relaxed);
    return;
  }
  slot->tick = tick;
  slot->timing = timing;
  slot->detectors.assign(tick.detectors.begin(), tick.detectors.end());
  for (DetectorTick& detector : slot->detectors) detector.late = {};  // until the next tick only
  slot->tick.detectors = slot->detectors;
  slot->events = 0;
  if (tick.events.size() > event_ring_.room()) {
    lost_events_.fetch_add(static_cast<std::int64_t>(tick.events.size()), std::memory_order_relaxed);
  } else {
    for (const Event& event : tick.events) {
      *event_ring_.claim() = event;
      event_ring_.publish();
    }
    slot->events = tick.events.size();
  }
  ticks_.publish();
}

void DeployRecorder::on_change(const DeployChange& change) {
  const std::lock_guard lock(changes_mutex_);
  changes_.push_back(change);
  new_lines_.emplace_back(change.t_us, text_of_change(change));
}

void DeployRecorder::on_news(std::int64_t t_us, const std::string& line) {
  const std::lock_guard lock(changes_mutex_);
  new_lines_.emplace_back(t_us, line);
}

void DeployRecorder::work() {
  for (;;) {
    const bool last = over_;  // read before the rings
    try {
      const bool found = drain();
      if (!found && last) return;
      if (found) continue;
      black_box_.flush();
    } catch (const std::exception& error) {
      if (failure_.empty()) print_line(std::string("the recording ended: ") + error.what());
      failure_ = error.what();
    }
    std::this_thread::sleep_for(pause);
  }
}

/// Returns whether there was anything.
bool DeployRecorder::drain() {
  std::vector<std::pair<std::int64_t, std::string>> lines;
  {
    const std::lock_guard lock(changes_mutex_);
    lines.swap(new_lines_);
  }
  for (const auto& [t_us, line] : lines) {
    black_box_.add(t_us, line);
    if (failure_.empty()) log_file_.write(t_us, line);
  }
  Slot* const slot = ticks_.front();
  if (slot == nullptr) return !lines.empty();
  tick_events_.clear();
  for (std::size_t i = 0; i < slot->events; ++i) {
    tick_events_.push_back(*event_ring_.front());
    event_ring_.pop();
  }
  try {
    write(*slot);
  } catch (...) {
    ticks_.pop();
    throw;
  }
  ticks_.pop();
  return true;
}

void DeployRecorder::write(Slot& slot) {
  const Tick& tick = slot.tick;
  if (!start_us_) {
    start_us_ = tick.t_us;
    next_timing_us_ = tick.t_us + timing_us;
    next_status_us_ = tick.t_us + (terminal_ ? terminal_status_us : log_status_us);
  }
  black_box_.add(tick, slot.timing, slot.detectors, tick_events_);
  if (++unflushed_ % 100 == 0) black_box_.flush();
  last_ = slot.timing;
  if (slot.timing.state == DeployState::active && !slot.timing.guarded) ++unguarded_;
  target_m_ = tick.target_m;
  phase_ = tick.phase;
  queued_most_ = std::max(queued_most_, slot.timing.traffic.queued);
  for (Figures* const figures : {&whole_, &timing_window_, &status_window_}) figures->add(slot);
  late_histogram_.add(slot.timing.begin_us - slot.timing.due_us);
  tick_histogram_.add(slot.timing.end_us - slot.timing.begin_us);
  ++ticks_in_window_;
  for (std::size_t i = 0; i < slot.detectors.size(); ++i) {
    const DetectorTick& detector = slot.detectors[i];
    detectors_[i].at_threshold += detector.at_threshold ? 1 : 0;
    detectors_[i].in_window += detector.at_threshold ? 1 : 0;
    detectors_[i].skipped += detector.skipped ? 1 : 0;
    detectors_[i].elapsed_ns += detector.elapsed_ns;
  }
  if (tick.t_us >= next_status_us_) {
    show_status();
    next_status_us_ = tick.t_us + (terminal_ ? terminal_status_us : log_status_us);
  }
  if (!failure_.empty()) return;

  log_.on_tick(tick);
  if (recording_) record(tick);
  if (tables_ended_) return;
  observations_.on_tick(tick);
  observations_.write_completed(detections_);
  if (tick.head && is_finite(*tick.head)) {
    const Eigen::Vector3d none = Eigen::Vector3d::Constant(nan);
    const FixationPoint fixation = HeadKinematics(loop_.head()->chain, tick.head->position_rad).fixation();
    gaze_.write({tick.t_us, fixation.valid ? fixation.point_m : none, tick.target_m.value_or(none),
                 tick.head->position_rad});
  }
  if (tick.t_us >= next_sync_us_) {
    next_sync_us_ = tick.t_us + table_sync_us;
    sync_tables(tick.t_us);
    if (tables_ended_) return;
  }
  if (tick.t_us >= next_timing_us_) {
    write_timing();
    next_timing_us_ += (tick.t_us - next_timing_us_) / timing_us * timing_us + timing_us;
  }
}

void DeployRecorder::sync_tables(std::int64_t t_us) {
  const std::int64_t least_mb = robot_.output.least_free_mb;
  if (free_bytes(folder_) >= least_mb * 1'000'000) {
    detections_.sync();
    gaze_.sync();
    timing_.sync();
    return;
  }
  log_file_.write(t_us, fmt::format("less than {} MB are free: the tables ended", least_mb));
  commit_tables();
}

void DeployRecorder::commit_tables() {
  detections_.commit();
  gaze_.commit();
  timing_.commit();
  tables_ended_ = true;
}

void DeployRecorder::record(const Tick& tick) {
  std::optional<JointsRow> joints;
  if (tick.head && is_finite(*tick.head) && tick.head->t_us > last_joints_us_) {
    last_joints_us_ = tick.head->t_us;
    joints = JointsRow{tick.head->t_us, tick.head->position_rad};
  }
  const bool had_ended = !recording_->ended().empty();
  recording_->write(tick.t_us, tick_events_, joints);
  if (!had_ended && !recording_->ended().empty()) log_file_.write(tick.t_us, recording_->ended());
}

void DeployRecorder::write_timing() {
  const Figures& f = timing_window_;
  const std::int64_t ticks = f.tick.count();
  if (ticks == 0) return;
  TimingRow row;
  row.t_us = last_.due_us;
  row.state = name_of(last_.state);
  row.ticks = ticks;
  row.missed = f.missed;
  row.late_max_us = f.late.max_us();
  row.tick_mean_us = mean(f.tick_sum_us, ticks);
  row.tick_max_us = f.tick.max_us();
  row.latency_mean_us = mean(f.latency_sum_us, f.latency.count());
  row.latency_max_us = f.latency.count() > 0 ? static_cast<double>(f.latency.max_us()) : nan;
  row.events = f.events;
  row.events_left_out = f.left_out;
  row.skipped = f.skipped;
  row.queued = last_.traffic.queued;
  row.dropped = last_.traffic.dropped;
  timing_.write(row);
  timing_window_ = {};
}

void DeployRecorder::show_status() {
  const Figures& f = status_window_;
  const double seconds = 1e-6 * static_cast<double>(last_.due_us - *start_us_);
  const double window_s = 1e-3 * robot_.deploy.tick_ms * static_cast<double>(ticks_in_window_ + f.missed);
  std::string line = fmt::format("{:<7} {:7.1f} s", name_of(last_.state), seconds);
  if (last_.state == DeployState::active && !last_.guarded) line += "  NO GUARD";
  for (std::size_t i = 0; i < detectors_.size(); ++i) {
    line += fmt::format("  {} {:3.0f} %", loop_.detectors()[i].name,
                        100.0 * mean(detectors_[i].in_window, ticks_in_window_));
    detectors_[i].in_window = 0;
  }
  if (phase_ == GazePhase::following && target_m_)
    line += fmt::format("  ball ({:.2f}, {:.2f}, {:.2f}) m", target_m_->x(), target_m_->y(), target_m_->z());
  line += fmt::format("  tick {:.2f} (99 %: {:.2f}, max {:.2f}) late {:.2f} (max {:.2f})",
                      ms(f.tick.quantile_us(0.5)), ms(f.tick.quantile_us(0.99)), ms(f.tick.max_us()),
                      ms(f.late.quantile_us(0.5)), ms(f.late.max_us()));
  if (f.latency.count() > 0)
    line +=
        fmt::format(" latency {:.2f} (max {:.2f})", ms(f.latency.quantile_us(0.5)), ms(f.latency.max_us()));
  line += fmt::format(" ms  {:.1f} kevent/s  queue {}  dropped {}  left out {}  skipped {}",
                      window_s > 0.0 ? 1e-3 * static_cast<double>(f.events) / window_s : 0.0,
                      last_.traffic.queued, last_.traffic.dropped, whole_.left_out, whole_.skipped);
  status_window_ = {};
  ticks_in_window_ = 0;
  if (terminal_) {
    line.resize(std::min(line.size(), terminal_width()));
    fmt::print(stderr, "\r\033[K{}", line);
    std::fflush(stderr);
    line_is_open_ = true;
  } else {
    fmt::print(stderr, "{}\n", line);
  }
}

void DeployRecorder::print_line(const std::string& line) {
  fmt::print(stderr, "{}{}\n", line_is_open_ ? "\r\033[K" : "", line);
  line_is_open_ = false;
}

void DeployRecorder::finish() {
  over_ = true;
  writer_.join();
  if (line_is_open_) fmt::print(stderr, "\n");
  line_is_open_ = false;
  if (!failure_.empty()) throw RunError(failure_);
  const bool tables_ended_early = tables_ended_;
  if (!tables_ended_) {
    write_timing();
    commit_tables();
  }
  log_.finish();
  log_file_.commit();
  if (recording_) recording_->commit();
  black_box_.flush();
  write_summary(tables_ended_early);
}

void DeployRecorder::write_summary(bool tables_ended_early) const {
  Metrics metrics;
  metrics.scenario = robot_.name;
  metrics.start_us = start_us_.value_or(0);
  metrics.duration_s = start_us_ ? 1e-6 * static_cast<double>(last_.due_us - *start_us_) : 0.0;
  metrics.event_count = whole_.events;
  metrics.events_dropped = last_.traffic.dropped + whole_.left_out;
  if (recording_) metrics.events_file = recording_->first_file();
  metrics.image = image_;
  metrics.camera = robot_.calibration.camera;
  metrics.calibration = robot_.calibration;
  for (std::size_t i = 0; i < detectors_.size(); ++i) {
    const LoopDetector& detector = loop_.detectors()[i];
    DetectorScore score;
    score.threshold = detector.detector->threshold();
    score.observations = detectors_[i].at_threshold;
    if (whole_.events > 0)
      score.us_per_event =
          1e-3 * static_cast<double>(detectors_[i].elapsed_ns) / static_cast<double>(whole_.events);
    score.rejected_events = detector.detector->rejected();
    score.failure = detector.detector->failure();
    metrics.detectors.emplace_back(detector.name, std::move(score));
  }
  for (const EndedProgram& program : ended_) {
    if (program.what == "gaze controller") metrics.controller_failure = program.why;
  }
  write_metrics(folder_ / "metrics.json", metrics);
  const auto in_ms = [](const TimeFigures& f) {
    return fmt::format("{:.3f} ms in the median, {:.3f} in 99 %, {:.3f} at most", ms(f.quantile_us(0.5)),
                       ms(f.quantile_us(0.99)), ms(f.max_us()));
  };
  fmt::print("{} ticks, {} missed\n  in a tick: {}\n  late: {}\n", whole_.tick.count(), whole_.missed,
             in_ms(whole_.tick), in_ms(whole_.late));
  if (whole_.latency.count() > 0) fmt::print("  from event to command: {}\n", in_ms(whole_.latency));
  fmt::print("{} events, {} dropped, {} left out; {} evaluations skipped\n", whole_.events,
             last_.traffic.dropped, whole_.left_out, whole_.skipped);

  using Json = nlohmann::json;
  Json json = {{"schema", 1},
               {"robot", robot_.name},
               {"backend", robot_.robot.backend},
               {"dry_run", facts_.dry_run},
               {"scheduling", scheduling_},
               {"guard", {{"use", word_of(robot_.deploy.guard)}, {"active_ticks_without", unguarded_}}},
               {"ticks",
                {{"count", whole_.tick.count()},
                 {"missed", whole_.missed},
                 {"us", json_of(whole_.tick)},
                 {"late_us", json_of(whole_.late)},
                 {"us_histogram", json_of(tick_histogram_)},
                 {"late_us_histogram", json_of(late_histogram_)}}},
               {"latency_us", json_of(whole_.latency)},
               {"events",
                {{"count", whole_.events},
                 {"packets", last_.traffic.packets},
                 {"queued_most", queued_most_},
                 {"dropped", last_.traffic.dropped},
                 {"left_out", whole_.left_out}}},
               {"skipped", Json::object()},
               {"not_recorded", {{"ticks", lost_ticks_.load()}, {"events", lost_events_.load()}}},
               {"recorded_files", recording_ ? recording_->count() : 0},
               {"recording_ended", recording_ ? recording_->ended() : ""},
               {"tables_ended", tables_ended_early},
               {"ended", Json::array()},
               {"checks", Json::array()},
               {"states", Json::array()}};
  for (std::size_t i = 0; i < detectors_.size(); ++i)
    json["skipped"][loop_.detectors()[i].name] = detectors_[i].skipped;
  for (const EndedProgram& program : ended_)
    json["ended"].push_back({{"t_us", program.t_us}, {"what", program.what}, {"why", program.why}});
  for (const StartUpCheck& check : facts_.checks)
    json["checks"].push_back({{"what", check.what}, {"passed", check.passed}, {"found", check.found}});
  for (const DeployChange& change : changes_) {
    Json state = {{"t_us", change.t_us}, {"state", name_of(change.state)}};
    if (!change.rejected.empty()) state["refused"] = change.rejected;
    if (!change.warning.empty()) state["warning"] = change.warning;
    if (change.stop) {
      state["cause"] = change.stop->description();
      state["fault"] = is_fault(change.stop->cause);
      state["since_us"] = change.stop->since_us;
      state["took_ms"] = ms(change.took_us);
    }
    json["states"].push_back(std::move(state));
  }
  OutputFile file(folder_ / "deploy.json");
  file.write(json.dump(2) + "\n");
  file.commit();
}

}  // namespace saccade
