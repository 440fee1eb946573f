#include "apps/view/player.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace saccade {
namespace {

using WallClock = std::chrono::steady_clock;
/// How long the thread ticks before it looks what is wished, s.
constexpr double turn_s = 0.008;

double seconds_since(WallClock::time_point begin) {
  return std::chrono::duration<double>(WallClock::now() - begin).count();
}

}  // namespace

// ---- Mailbox ---------------------------------------------------------------------------------------

void Mailbox::send() {
  const std::lock_guard lock(mutex_);
  std::swap(spare_, posted_);
  fresh_ = true;
  wanted_.store(false, std::memory_order_relaxed);
}

bool Mailbox::take(Picture& picture) {
  const std::lock_guard lock(mutex_);
  wanted_.store(true, std::memory_order_relaxed);
  if (!fresh_) return false;
  std::swap(picture, posted_);
  fresh_ = false;
  return true;
}

// ---- Player ----------------------------------------------------------------------------------------

Player::Player(std::function<std::unique_ptr<Play>()> make, bool playing) {
  wishes_.playing = playing;
  wishes_.version = 1;
  thread_ = std::thread([this, make = std::move(make)] { run(make); });
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return ready_ || failure_; });
  if (!failure_) return;
  lock.unlock();
  thread_.join();
  std::rethrow_exception(failure_);
}

Player::~Player() {
  {
    const std::lock_guard lock(mutex_);
    closing_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

template <class Change>
void Player::wish(Change change) {
  {
    const std::lock_guard lock(mutex_);
    change(wishes_);
    ++wishes_.version;
  }
  changed_.notify_all();
}

void Player::play(bool playing) {
  wish([&](Wishes& w) { w.playing = playing; });
}
void Player::set_speed(double speed) {
  wish([&](Wishes& w) { w.speed = speed; });
}
void Player::seek(std::int64_t t_us) {
  wish([&](Wishes& w) {
    w.seek_us = t_us;
    w.step_us = 0;
  });
}
void Player::step(std::int64_t by_us) {
  wish([&](Wishes& w) {
    w.playing = false;
    w.step_us += by_us;
  });
}
void Player::set(const ViewSettings& settings) {
  wish([&](Wishes& w) { w.settings = settings; });
}

bool Player::take(Picture& picture) {
  {
    const std::lock_guard lock(mutex_);
    if (failure_) std::rethrow_exception(failure_);
  }
  const bool taken = mailbox_.take(picture);
  changed_.notify_all();
  return taken;
}

void Player::run(const std::function<std::unique_ptr<Play>()>& make) {
  try {
    play_ = make();
    first_settings_ = play_->settings();
    overview_ = play_->overview();
    {
      const std::lock_guard lock(mutex_);
      ready_ = true;
    }
    changed_.notify_all();
    for (;;) {
      {
        std::unique_lock lock(mutex_);
        const auto something = [this] {
          return closing_ || wishes_.version != heard_ || playing_ || seek_us_ ||
                 (dirty_ && mailbox_.wanted());
        };
        changed_.wait(lock, something);
        if (closing_) break;
      }
      obey();
      go_on();
      const bool goes_on = playing_ || seek_us_;
      if (dirty_ && mailbox_.wanted() && !(goes_on && WallClock::now() < next_post_)) post();
    }
    play_.reset();
  } catch (...) {
    const std::lock_guard lock(mutex_);
    failure_ = std::current_exception();
    changed_.notify_all();
  }
}

void Player::obey() {
  Wishes wishes;
  {
    const std::lock_guard lock(mutex_);
    if (wishes_.version == heard_) return;
    wishes = wishes_;
    wishes_.seek_us.reset();
    wishes_.step_us = 0;
    wishes_.settings.reset();
  }
  heard_ = wishes.version;
  dirty_ = true;
  if (wishes.settings) {
    try {
      play_->apply(*wishes.settings);
      problem_.clear();
    } catch (const InputError& error) {
      problem_ = error.what();
    }
  }
  playing_ = wishes.playing;
  speed_ = wishes.speed;
  pace_.reset();
  measured_.reset();
  if (wishes.seek_us) seek_us_ = wishes.seek_us;
  if (wishes.step_us != 0) seek_us_ = seek_us_.value_or(play_->watcher().now_us()) + wishes.step_us;
  if (!seek_us_) return;
  const Watcher& watcher = play_->watcher();
  seek_us_ = watcher.start_us() + (*seek_us_ - watcher.start_us()) / Play::tick_us * Play::tick_us;
  seek_us_ = std::clamp(*seek_us_, watcher.start_us() + Play::tick_us, watcher.end_us());
  if (*seek_us_ != watcher.now_us()) play_->go_back(*seek_us_);
}

void Player::go_on() {
  if (!playing_ && !seek_us_) return;
  const WallClock::time_point begin = WallClock::now();
  const Watcher& watcher = play_->watcher();
  const auto tick = [&] {
    dirty_ = true;
    return play_->tick();
  };
  if (seek_us_) {
    pace_.reset();
    while (watcher.now_us() < *seek_us_ && seconds_since(begin) < turn_s) {
      if (!tick()) seek_us_ = watcher.now_us();
    }
    if (watcher.now_us() >= *seek_us_) seek_us_.reset();
    return;
  }
  if (!pace_) pace_ = Pace{begin, watcher.now_us()};
  if (!measured_) measured_ = pace_;
  bool ended = false;
  while (!ended && seconds_since(begin) < turn_s) {
    if (speed_ != fastest) {
      const double due_us = seconds_since(pace_->wall) * 1e6 * speed_;
      const double done_us = static_cast<double>(watcher.now_us() - pace_->t_us);
      if (done_us + static_cast<double>(Play::tick_us) > due_us) {
        // Until the next tick is due or something is wished, whatever comes first.
        const double wait_s = (done_us + static_cast<double>(Play::tick_us) - due_us) * 1e-6 / speed_;
        std::unique_lock lock(mutex_);
        changed_.wait_for(lock, std::chrono::duration<double>(std::min(wait_s, turn_s)));
        break;
      }
      // What cannot be kept up with is not made up for.
      if (due_us - done_us > 1e5) pace_ = Pace{WallClock::now(), watcher.now_us()};
    }
    ended = !tick();
  }
  const double measured_s = seconds_since(measured_->wall);
  if (measured_s > 0.25) {
    reached_speed_ = static_cast<double>(watcher.now_us() - measured_->t_us) * 1e-6 / measured_s;
    measured_ = Pace{WallClock::now(), watcher.now_us()};
  }
  if (!ended) return;
  playing_ = false;
  const std::lock_guard lock(mutex_);
  if (wishes_.version == heard_) wishes_.playing = false;
}

void Player::post() {
  const WallClock::time_point begin = WallClock::now();
  Picture& picture = mailbox_.spare();
  play_->fill(picture);
  picture.playing = playing_;
  picture.seeking = seek_us_.has_value();
  picture.speed = reached_speed_;
  // What is sought is not yet there.
  picture.handled = seek_us_ ? 0 : heard_;
  picture.problem = problem_;
  mailbox_.send();
  dirty_ = false;
  const WallClock::time_point end = WallClock::now();
  next_post_ = end + 2 * (end - begin);
}

}  // namespace saccade
