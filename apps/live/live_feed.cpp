#include "apps/live/live_feed.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <limits>
#include <nlohmann/json.hpp>

#include "apps/live/live_message.h"
#include "core/units.h"
#include "evaluation/report/palette.h"

namespace saccade {
namespace {

using Json = nlohmann::ordered_json;

constexpr auto period = std::chrono::milliseconds(33);
constexpr std::size_t most_events = std::size_t{1} << 16;
constexpr std::size_t most_detections = std::size_t{1} << 14;
constexpr std::size_t most_instants = std::size_t{1} << 12;
constexpr std::size_t most_lines = 20;
constexpr std::size_t longest_line = 300;
constexpr double none = std::numeric_limits<double>::quiet_NaN();
constexpr double px_step = 0.01;
constexpr double deg_step = 0.01;
constexpr double ms_step = 1e-3;
constexpr double score_step = 1e-4;

template <class Rows, class Value>
void add_numbers(PackedTable& table, const char* name, double step, const Rows& rows, Value value) {
  std::vector<double> values;
  values.reserve(rows.size());
  for (const auto& row : rows) values.push_back(value(row));
  table.add_numbers(name, step, values);
}

template <class Rows>
void add_times(PackedTable& table, const Rows& rows, std::int64_t start_us) {
  std::vector<std::int64_t> times;
  times.reserve(rows.size());
  std::int64_t last = 0;  // late events come out of order
  for (const auto& row : rows) times.push_back(last = std::max(last, row.t_us - start_us));
  table.add_times("t", times);
}

/// Events of one camera.
std::optional<PackedTable> event_table(const std::vector<Event>& all, std::uint8_t camera,
                                       std::int64_t start_us) {
  std::vector<Event> events;
  std::ranges::copy_if(all, std::back_inserter(events), [&](const Event& e) { return e.camera == camera; });
  if (events.empty()) return std::nullopt;
  std::ranges::stable_sort(events, {}, &Event::t_us);
  PackedTable table(camera == 0 ? "events" : "events_right", events.size());
  std::vector<std::uint16_t> x;
  std::vector<std::uint16_t> y;
  std::vector<bool> on;
  for (const Event& event : events) {
    x.push_back(event.x);
    y.push_back(event.y);
    on.push_back(event.on);
  }
  add_times(table, events, start_us);
  table.add_words("x", true, x);
  table.add_words("y", true, y);
  table.add_bits("on", on);
  return table;
}

}  // namespace

LiveFeed::LiveFeed(LiveServer& server, LiveRun run, const Loop& loop)
    : server_(server),
      run_(std::move(run)),
      filling_(std::make_unique<Batch>()),
      sending_(std::make_unique<Batch>()) {
  for (const LoopDetector& detector : loop.detectors())
    detectors_.emplace_back(detector.name, detector.detector->threshold());
  for (Batch* const batch : {filling_.get(), sending_.get()}) {
    batch->events.reserve(most_events);
    batch->detections.reserve(most_detections);
    batch->instants.reserve(most_instants);
    batch->lines.reserve(most_lines);
    batch->state.reserve(longest_line);
  }
  server_.set_greeting(greeting());
  server_.publish(greeting());  // for those who were there before
  thread_ = std::thread([this] { this->run(); });
}

LiveFeed::~LiveFeed() {
  {
    const std::lock_guard lock(end_mutex_);
    over_ = true;
  }
  end_.notify_one();
  thread_.join();
}

std::string LiveFeed::greeting() const {
  Json detectors = Json::array();
  for (const auto& [name, threshold] : detectors_)
    detectors.push_back({{"name", name}, {"threshold", threshold}, {"colour", hex(detector_colour(name))}});
  Json joints = Json::array();
  if (run_.head != nullptr) {
    for (const HeadJoint& joint : run_.head->joints) joints.push_back(joint.name);
  }
  Json head = {{"kind", run_.kind},
               {"title", run_.title},
               {"size", {run_.size.width, run_.size.height}},
               {"both_eyes", run_.both_eyes},
               {"detectors", std::move(detectors)},
               {"joints", std::move(joints)},
               {"can_stop", run_.can_stop},
               {"colours",
                {{"on", hex(on_colour)},
                 {"off", hex(off_colour)},
                 {"truth", hex(truth_colour)},
                 {"gaze", hex(gaze_colour)},
                 {"target", hex(gaze_target_colour)}}}};
  for (const LiveBound& watchdog : run_.watchdogs)
    head["watchdogs"].push_back(
        {{"name", watchdog.name}, {"column", watchdog.column}, {"bound", watchdog.bound_ms}});
  if (run_.duration_s) head["duration"] = *run_.duration_s;
  if (run_.principal_px) head["principal"] = {run_.principal_px->x(), run_.principal_px->y()};
  return live_message(std::move(head));
}

/// What is new of state and log; strings are moved.
void LiveFeed::hand_over_text(Batch& batch) {
  batch.state.assign(state_, 0, longest_line);
  batch.alarm = alarm_;
  std::size_t taken = 0;
  for (; taken < new_lines_.size() && batch.lines.size() < most_lines; ++taken)
    batch.lines.push_back(std::move(new_lines_[taken]));
  new_lines_.erase(new_lines_.begin(), new_lines_.begin() + static_cast<std::ptrdiff_t>(taken));
}

void LiveFeed::on_tick(const Tick& tick) {
  if (start_us_ == not_started) start_us_ = tick.t_us;
  const bool seen = server_.clients() > 0;
  if (!seen && new_lines_.empty()) return;
  const std::unique_lock lock(mutex_, std::try_to_lock);
  if (!lock) {
    if (seen) ++missed_;
    return;
  }
  Batch& batch = *filling_;
  hand_over_text(batch);
  if (!seen) return;
  const std::size_t room = most_events - batch.events.size();
  const std::size_t count = std::min(room, tick.events.size());
  // The newest: the page shows what is now.
  batch.events.insert(batch.events.end(), tick.events.end() - static_cast<std::ptrdiff_t>(count),
                      tick.events.end());
  missed_ += tick.events.size() - count;
  for (std::size_t i = 0; i < tick.detectors.size(); ++i) {
    const DetectorTick& result = tick.detectors[i];
    if (!result.observed || batch.detections.size() == most_detections) continue;
    batch.detections.push_back(
        {i, tick.t_us, result.estimate.circle, result.estimate.score, result.estimate.held});
  }
  if (batch.instants.size() == most_instants) {
    ++missed_;
    return;
  }
  Instant& instant = batch.instants.emplace_back();
  instant.t_us = tick.t_us;
  instant.has_head = tick.head.has_value();
  if (tick.head) instant.position_rad = tick.head->position_rad;
  instant.truth = truth_;
  instant.timing = timing_;
}

void LiveFeed::set_state(std::string_view state, bool alarm) {
  state_ = state;
  alarm_ = alarm;
}

void LiveFeed::add_line(std::int64_t t_us, std::string_view line) {
  if (new_lines_.size() == most_lines) new_lines_.erase(new_lines_.begin());
  new_lines_.push_back(
      fmt::format("{:.3f} s  {}", 1e-6 * static_cast<double>(t_us), line.substr(0, longest_line)));
}

void LiveFeed::run() {
  std::unique_lock end(end_mutex_);
  for (auto due = std::chrono::steady_clock::now() + period;
       !end_.wait_until(end, due, [this] { return over_; });
       due = std::max(due + period, std::chrono::steady_clock::now())) {
    {
      const std::lock_guard lock(mutex_);
      std::swap(filling_, sending_);
    }
    for (std::string& line : sending_->lines) {
      lines_.push_back(std::move(line));
      if (lines_.size() > most_lines) lines_.pop_front();
    }
    sending_->lines.clear();
    if (!sending_->instants.empty() && server_.clients() > 0) send(*sending_);
    sending_->events.clear();
    sending_->detections.clear();
    sending_->instants.clear();
  }
}

void LiveFeed::send(const Batch& batch) {
  const std::int64_t start_us = start_us_;
  std::vector<PackedTable> tables;
  for (const std::uint8_t camera : {std::uint8_t{0}, std::uint8_t{1}}) {
    if (auto table = event_table(batch.events, camera, start_us)) tables.push_back(std::move(*table));
  }
  for (std::size_t i = 0; i < detectors_.size(); ++i) {
    std::vector<Detection> own;
    std::ranges::copy_if(batch.detections, std::back_inserter(own),
                         [&](const Detection& d) { return d.detector == i; });
    if (own.empty()) continue;
    PackedTable table("detections_" + std::to_string(i), own.size());
    add_times(table, own, start_us);
    add_numbers(table, "x", px_step, own, [](const Detection& d) { return d.circle.x_px; });
    add_numbers(table, "y", px_step, own, [](const Detection& d) { return d.circle.y_px; });
    add_numbers(table, "r", px_step, own, [](const Detection& d) { return d.circle.r_px; });
    add_numbers(table, "score", score_step, own, [](const Detection& d) { return d.score; });
    add_numbers(table, "held", 1.0, own, [](const Detection& d) { return d.held ? 1.0 : 0.0; });
    tables.push_back(std::move(table));
  }
  const std::vector<Instant>& rows = batch.instants;
  PackedTable table("instants", rows.size());
  add_times(table, rows, start_us);
  const auto add = [&](const char* name, double step, auto value) {
    add_numbers(table, name, step, rows, value);
  };
  add("x", px_step, [](const Instant& i) { return i.truth.circle ? i.truth.circle->x_px : none; });
  add("y", px_step, [](const Instant& i) { return i.truth.circle ? i.truth.circle->y_px : none; });
  add("r", px_step, [](const Instant& i) { return i.truth.circle ? i.truth.circle->r_px : none; });
  add("visible", px_step, [](const Instant& i) { return i.truth.visible; });
  add("error", deg_step, [](const Instant& i) { return i.truth.gaze_error_deg.value_or(none); });
  add("target_px_x", px_step,
      [](const Instant& i) { return i.truth.target_px ? i.truth.target_px->x() : none; });
  add("target_px_y", px_step,
      [](const Instant& i) { return i.truth.target_px ? i.truth.target_px->y() : none; });
  add("late", ms_step, [](const Instant& i) { return i.timing ? i.timing->late_ms : none; });
  add("tick", ms_step, [](const Instant& i) { return i.timing ? i.timing->tick_ms : none; });
  add("latency", ms_step,
      [](const Instant& i) { return i.timing ? i.timing->latency_ms.value_or(none) : none; });
  add("camera_age", ms_step, [](const Instant& i) { return i.timing ? i.timing->camera_age_ms : none; });
  add("joints_age", ms_step,
      [](const Instant& i) { return i.timing ? i.timing->joints_age_ms.value_or(none) : none; });
  if (run_.head != nullptr) {
    std::size_t number = 0;
    for (const HeadJoint& joint : run_.head->joints) {
      const std::string name = "joint_" + std::to_string(number++);
      add(name.c_str(), deg_step,
          [&](const Instant& i) { return i.has_head ? i.position_rad[joint.slot] * deg_per_rad : none; });
    }
  }
  tables.push_back(std::move(table));
  Json head = {{"now", rows.back().t_us - start_us},
               {"missed", missed_.load()},
               {"state", batch.state},
               {"alarm", batch.alarm},
               {"lines", lines_},
               {"stops", server_.stops()}};
  if (const auto& timing = rows.back().timing) {
    head["skipped_ticks"] = timing->skipped_ticks;
    head["dropped_events"] = timing->dropped_events;
    head["guarded"] = timing->guarded;
  }
  server_.publish(live_message(std::move(head), tables));
}

}  // namespace saccade
