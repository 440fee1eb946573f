#include "apps/view/player_thread.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

namespace saccade {
namespace {

/// For how long the thread ticks before it looks for requests, s.
constexpr double slice_s = 0.008;

double seconds_since(WallClock::time_point begin) { return seconds_between(begin, WallClock::now()); }

}  // namespace

PlayerThread::PlayerThread(std::function<std::unique_ptr<Playback>()> make, bool playing) {
  requests_.playing = playing;
  requests_.number = 1;
  thread_ = std::thread([this, make = std::move(make)] { run(make); });
}

PlayerThread::~PlayerThread() {
  {
    const std::lock_guard lock(mutex_);
    closing_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

template <class Change>
void PlayerThread::request(Change change) {
  {
    const std::lock_guard lock(mutex_);
    change(requests_);
    ++requests_.number;
    kept_settings_.reset();
  }
  changed_.notify_all();
}

void PlayerThread::play(bool playing) {
  request([&](Requests& r) { r.playing = playing; });
}
void PlayerThread::set_speed(double speed) {
  request([&](Requests& r) { r.speed = speed; });
}
void PlayerThread::seek(std::int64_t t_us) {
  request([&](Requests& r) {
    r.seek_us = t_us;
    r.step_us = 0;
  });
}
void PlayerThread::step(std::int64_t by_us) {
  request([&](Requests& r) {
    r.playing = false;
    r.step_us += by_us;
  });
}
void PlayerThread::apply(const ViewSettings& settings) {
  request([&](Requests& r) { r.settings = settings; });
}

std::optional<ViewSettings> PlayerThread::take_kept_settings() {
  const std::lock_guard lock(mutex_);
  return std::exchange(kept_settings_, std::nullopt);
}

bool PlayerThread::ready() {
  const std::lock_guard lock(mutex_);
  if (failure_) std::rethrow_exception(failure_);
  return ready_;
}

bool PlayerThread::take(Snapshot& snapshot) {
  {
    const std::lock_guard lock(mutex_);
    if (failure_) std::rethrow_exception(failure_);
  }
  const bool taken = channel_.take(snapshot);
  {
    // The thread looks at the channel with the mutex held, or is notified after it did.
    const std::lock_guard lock(mutex_);
  }
  changed_.notify_all();
  return taken;
}

void PlayerThread::run(const std::function<std::unique_ptr<Playback>()>& make) {
  try {
    playback_ = make();
    first_settings_ = playback_->settings();
    event_counts_ = playback_->event_counts();
    {
      const std::lock_guard lock(mutex_);
      ready_ = true;
    }
    for (;;) {
      {
        std::unique_lock lock(mutex_);
        const auto has_work = [this] {
          return closing_ || requests_.number != applied_ || playing_ || seek_us_ ||
                 (dirty_ && channel_.requested());
        };
        changed_.wait(lock, has_work);
        if (closing_) break;
      }
      apply_requests();
      advance();
      const bool moves = playing_ || seek_us_;
      if (dirty_ && channel_.requested() && !(moves && WallClock::now() < next_publish_)) publish_snapshot();
    }
    playback_.reset();
  } catch (...) {
    const std::lock_guard lock(mutex_);
    failure_ = std::current_exception();
  }
}

void PlayerThread::apply_requests() {
  Requests requests;
  {
    const std::lock_guard lock(mutex_);
    if (requests_.number == applied_) return;
    requests = requests_;
    requests_.seek_us.reset();
    requests_.step_us = 0;
    requests_.settings.reset();
  }
  applied_ = requests.number;
  dirty_ = true;
  if (requests.settings) {
    try {
      playback_->apply(*requests.settings);
      problem_.clear();
    } catch (const std::exception& error) {  // also of a detector's or a controller's own program
      problem_ = error.what();
      const std::lock_guard lock(mutex_);
      if (requests_.number == applied_) kept_settings_ = playback_->settings();
    }
  }
  playing_ = requests.playing;
  speed_ = requests.speed;
  pace_.reset();
  measured_.reset();
  const LoopHistory& history = playback_->history();
  if (requests.seek_us) seek_us_ = requests.seek_us;
  if (requests.step_us != 0) seek_us_ = seek_us_.value_or(history.now_us()) + requests.step_us;
  if (!seek_us_) return;
  constexpr std::int64_t tick_us = Playback::tick_us;
  seek_us_ = history.start_us() + (*seek_us_ - history.start_us()) / tick_us * tick_us;
  seek_us_ = std::clamp(*seek_us_, history.start_us() + tick_us, history.end_us());
  if (*seek_us_ == history.now_us()) return;
  try {
    playback_->restore_before(*seek_us_);
    if (!requests.settings) problem_.clear();
  } catch (const std::exception& error) {
    problem_ = error.what();
    seek_us_.reset();
  }
}

void PlayerThread::advance_to(std::int64_t t_us) {
  const WallClock::time_point begin = WallClock::now();
  const LoopHistory& history = playback_->history();
  bool ended = false;
  while (!ended && history.now_us() < t_us && seconds_since(begin) < slice_s) {
    dirty_ = true;
    ended = !playback_->tick();
  }
  if (ended || history.now_us() >= t_us) seek_us_.reset();
}

void PlayerThread::advance() {
  if (seek_us_) {
    pace_.reset();
    advance_to(*seek_us_);
    return;
  }
  if (!playing_) return;
  const WallClock::time_point begin = WallClock::now();
  const LoopHistory& history = playback_->history();
  if (!pace_) pace_ = TimePair{begin, history.now_us()};
  if (!measured_) measured_ = pace_;
  bool ended = false;
  while (!ended && seconds_since(begin) < slice_s) {
    if (speed_ != unlimited_speed) {
      const double due_us = seconds_since(pace_->wall) * 1e6 * speed_;
      const double done_us = static_cast<double>(history.now_us() - pace_->t_us);
      const double ahead_us = done_us + static_cast<double>(Playback::tick_us) - due_us;
      if (ahead_us > 0.0) {
        // Until the next tick is due or a request comes, whichever is first.
        std::unique_lock lock(mutex_);
        changed_.wait_for(lock, std::chrono::duration<double>(std::min(ahead_us * 1e-6 / speed_, slice_s)));
        break;
      }
      // Lost time is not made up for.
      if (due_us - done_us > 1e5) pace_ = TimePair{WallClock::now(), history.now_us()};
    }
    dirty_ = true;
    ended = !playback_->tick();
  }
  const double measured_s = seconds_since(measured_->wall);
  if (measured_s > 0.25) {
    reached_speed_ = static_cast<double>(history.now_us() - measured_->t_us) * 1e-6 / measured_s;
    measured_ = TimePair{WallClock::now(), history.now_us()};
  }
  if (!ended) return;
  playing_ = false;
  const std::lock_guard lock(mutex_);
  if (requests_.number == applied_) requests_.playing = false;
}

void PlayerThread::publish_snapshot() {
  const WallClock::time_point begin = WallClock::now();
  Snapshot& snapshot = channel_.back();
  playback_->fill(snapshot);
  snapshot.playing = playing_;
  snapshot.seeking = seek_us_.has_value();
  snapshot.speed = reached_speed_;
  snapshot.request = seek_us_ ? 0 : applied_;  // a seek that is under way is not included
  snapshot.problem = problem_;
  channel_.publish();
  dirty_ = false;
  const WallClock::time_point end = WallClock::now();
  next_publish_ = end + 2 * (end - begin);
}

}  // namespace saccade
