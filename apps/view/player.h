#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>

#include "apps/view/play.h"

namespace saccade {

/// Hands pictures from the thread of a loop to that of the window: the newest one, and only when it is wanted, so
/// that a loop does no work for pictures that nobody looks at.
class Mailbox {
 public:
  /// The loop's thread: whether to fill a picture; then fill spare() and send it.
  [[nodiscard]] bool wanted() const { return wanted_.load(std::memory_order_relaxed); }
  [[nodiscard]] Picture& spare() { return spare_; }
  void send();
  /// The window's thread: true when there is a picture that was not taken before; it is swapped into `picture`.
  bool take(Picture& picture);
  /// The window's thread: no more pictures, for good.
  void decline() { wanted_.store(false, std::memory_order_relaxed); }

 private:
  std::atomic<bool> wanted_ = true;
  std::mutex mutex_;
  bool fresh_ = false;
  Picture spare_;   // of the loop's thread
  Picture posted_;  // of whoever has the mutex
};

/// Plays a Play in a thread of its own, as a person wishes.
class Player {
 public:
  static constexpr double fastest = 0.0;  ///< speed: as fast as it goes

  /// `make` is called in the thread, where OpenGL contexts then belong. Throws what it throws.
  Player(std::function<std::unique_ptr<Play>()> make, bool playing);
  ~Player();
  Player(const Player&) = delete;
  Player& operator=(const Player&) = delete;

  // Wishes. All from the window's thread; each gets a number, which Picture::handled tells.
  void play(bool playing);
  /// Simulated or recorded time per time.
  void set_speed(double speed);
  void seek(std::int64_t t_us);
  /// Pauses and goes on by so much; back where it is negative.
  void step(std::int64_t by_us);
  void set(const ViewSettings& settings);
  [[nodiscard]] std::uint64_t last_wish() const { return wishes_.version; }

  /// As Mailbox::take. Throws what ended the thread.
  bool take(Picture& picture);
  /// What was there at the start.
  [[nodiscard]] const ViewSettings& settings() const { return first_settings_; }
  [[nodiscard]] const std::vector<float>& overview() const { return overview_; }

 private:
  struct Wishes {
    std::uint64_t version = 0;
    bool playing = false;
    double speed = 1.0;
    std::optional<std::int64_t> seek_us;
    std::int64_t step_us = 0;
    std::optional<ViewSettings> settings;
  };
  template <class Change>
  void wish(Change change);

  void run(const std::function<std::unique_ptr<Play>()>& make);
  void obey();
  void go_on();
  void post();

  // Shared, under mutex_:
  std::mutex mutex_;
  std::condition_variable changed_;
  Wishes wishes_;
  bool ready_ = false;
  bool closing_ = false;
  std::exception_ptr failure_;
  Mailbox mailbox_;
  // Of the thread:
  std::unique_ptr<Play> play_;
  std::uint64_t heard_ = 0;  // the newest wish
  bool playing_ = false;
  double speed_ = 1.0;
  std::optional<std::int64_t> seek_us_;
  std::string problem_;
  bool dirty_ = true;  // something is to be seen that was not posted
  std::chrono::steady_clock::time_point
      next_post_;  // while it goes on: pictures get a third of the time at most
  double reached_speed_ = 0.0;
  struct Pace {
    std::chrono::steady_clock::time_point wall;
    std::int64_t t_us;
  };
  std::optional<Pace> pace_;      // of playing at speed_
  std::optional<Pace> measured_;  // of reached_speed_
  // Written before ready_:
  ViewSettings first_settings_;
  std::vector<float> overview_;
  std::thread thread_;
};

}  // namespace saccade
