#include "robot/replay/replay_robot.h"

#include <limits>

#include "core/error.h"
#include "core/time_stamp.h"
#include "recording/run_file_names.h"

namespace saccade {
namespace {

constexpr std::size_t block_events = 4096;
constexpr std::int64_t never_us = std::numeric_limits<std::int64_t>::min();

std::string name_of(const EventReader& reader) {
  return reader.path().empty() ? "recording" : reader.path().string();
}

ImageSize known_size(const EventReader& reader) {
  if (const auto size = reader.image_size()) return *size;
  throw InputError(name_of(reader), reader.format() + " without an image size", "--size WIDTHxHEIGHT");
}

}  // namespace

void check_event_gap(const std::string& where, std::int64_t last_us, std::int64_t next_us) {
  constexpr double longest_s = 86'400.0;
  const double gap_s = difference_s(next_us, last_us);
  if (gap_s <= longest_s) return;
  throw InputError(where,
                   "no events for " + text_of(gap_s) + " s after " + std::to_string(last_us) +
                       " us, as after a wrong time stamp or with those of two clocks",
                   "events at most a day apart; saccade convert --from S --until S keeps a part");
}

std::optional<TableReader<ImuRow>> recorded_imu(const std::filesystem::path& folder) {
  const std::filesystem::path imu = folder / run_file::imu;
  if (!std::filesystem::exists(imu)) return std::nullopt;
  return TableReader<ImuRow>(imu);
}

PortStatus ReplayImu::read_imu(ImuReading& reading) {
  if (status_ == PortStatus::ok) reading = reading_;
  return status_;
}

void ReplayImu::advance_to(std::int64_t now_us) {
  for (; next_ && next_->t_us <= now_us; next_ = rows_.next()) reading_ = next_->reading;
}

ReplayHead::ReplayHead(RecordedHead recording)
    : recording_(std::move(recording)), next_(recording_.joints.next()) {
  if (!next_) throw InputError("joints", "a table without rows", "at least one row");
  state_.t_us = next_->t_us;
  advance_to(state_.t_us);
  state_.velocity_rad_s.setZero();
}

void ReplayHead::advance_to(std::int64_t now_us) {
  for (; next_ && next_->t_us <= now_us; next_ = recording_.joints.next()) {
    if (next_->t_us > state_.t_us) {
      const double dt_s = 1e-6 * static_cast<double>(next_->t_us - state_.t_us);
      state_.velocity_rad_s = (next_->position_rad - state_.position_rad) / dt_s;
    }
    state_.t_us = next_->t_us;
    state_.position_rad = next_->position_rad;
  }
}

PortStatus ReplayHead::read(HeadState& state) {
  if (status_ == PortStatus::ok) state = state_;
  return status_;
}

HeadPort::CommandResult ReplayHead::command(const HeadCommand& reference_rad) {
  return {status_, !is_allowed(reference_rad, recording_.limits)};
}

ReplayRobot::ReplayRobot(std::unique_ptr<EventReader> events, std::optional<RecordedHead> head)
    : reader_(std::move(events)), image_size_(known_size(*reader_)), last_us_(never_us) {
  block_.reserve(block_events);
  if (head) {
    if (head->imu) imu_.emplace(std::move(*head->imu));
    head_.emplace(std::move(*head));
    now_us_ = last_us_ = head_->t_us();
    if (imu_) imu_->advance_to(now_us_);
  } else if (const Event* first = next()) {
    now_us_ = first->t_us;
  }
}

/// The next event to deliver; null at the end.
const Event* ReplayRobot::next() {
  for (;; ++position_) {
    if (position_ == block_.size()) {
      block_.clear();
      position_ = 0;
      if (reader_->read(block_, block_events) == 0) return nullptr;
    }
    const Event& event = block_[position_];
    const bool back_in_time = event.t_us < last_us_;
    if (!back_in_time && image_size_.contains(event.x, event.y)) return &event;
    if (back_in_time && !delivered_) {
      ++events_before_start_;
    } else {
      ++(back_in_time ? rejected_.back_in_time : rejected_.outside_image);
    }
  }
}

bool ReplayRobot::is_over() { return next() == nullptr && (!head_ || head_->at_last_row()); }

PortStatus ReplayRobot::wait_until(std::int64_t t_us) {
  if (ended_) return PortStatus::ended;
  if (t_us <= now_us_) return PortStatus::ok;
  if (is_over()) {
    ended_ = true;
    if (head_) head_->end();
    if (imu_) imu_->end();
    return PortStatus::ended;
  }
  if (const Event* const event = next(); event != nullptr && last_us_ != never_us)
    check_event_gap(name_of(*reader_), last_us_, event->t_us);
  now_us_ = t_us;
  if (head_) head_->advance_to(now_us_);
  if (imu_) imu_->advance_to(now_us_);
  return PortStatus::ok;
}

EventTraffic ReplayRobot::traffic() const {
  EventTraffic traffic;
  traffic.dropped = rejected_.outside_image + rejected_.back_in_time;
  return traffic;
}

PortStatus ReplayRobot::read_until(std::int64_t t_us, std::vector<Event>& events) {
  if (ended_) return PortStatus::ended;
  SACCADE_CHECK(t_us <= now_us_);
  for (const Event* event = next(); event != nullptr && event->t_us <= t_us; event = next()) {
    events.push_back(*event);
    last_us_ = event->t_us;
    delivered_ = true;
    ++position_;
  }
  return is_over() ? PortStatus::ended : PortStatus::ok;
}

}  // namespace saccade
