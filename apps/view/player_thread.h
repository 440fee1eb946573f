#pragma once

#include <condition_variable>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "apps/view/playback.h"
#include "apps/view/snapshot_channel.h"
#include "apps/view/wall_clock.h"

namespace saccade {

/// Plays a Playback in a thread of its own, as the requests of the window's thread say.
class PlayerThread {
 public:
  static constexpr double unlimited_speed = 0.0;

  /// `make` is called in the thread, since OpenGL contexts belong to a thread. The constructor does not wait for it.
  PlayerThread(std::function<std::unique_ptr<Playback>()> make, bool playing);
  /// Waits for the thread, also while it is still in `make`.
  ~PlayerThread();
  PlayerThread(const PlayerThread&) = delete;
  PlayerThread& operator=(const PlayerThread&) = delete;

  // Requests, all from the window's thread. Each gets the next number; see Snapshot::request.
  void play(bool playing);
  /// Simulated or recorded time per wall-clock time, or unlimited_speed.
  void set_speed(double speed);
  void seek(std::int64_t t_us);
  /// Pauses and moves on by so much; back where it is negative.
  void step(std::int64_t by_us);
  void apply(const ViewSettings& settings);
  /// Once after the newest request could not be applied: the settings that go on. Snapshot::problem has the reason.
  [[nodiscard]] std::optional<ViewSettings> take_kept_settings();
  [[nodiscard]] std::uint64_t last_request() const { return requests_.number; }

  /// Whether the playback has been made. Throws what ended the thread.
  [[nodiscard]] bool ready();
  /// As SnapshotChannel::take. Throws what ended the thread.
  bool take(Snapshot& snapshot);
  /// Settings and event counts of the playback at the start, once it is ready().
  [[nodiscard]] const ViewSettings& settings() const { return first_settings_; }
  [[nodiscard]] const std::vector<float>& event_counts() const { return event_counts_; }

 private:
  struct Requests {
    std::uint64_t number = 0;  ///< of the newest request
    bool playing = false;
    double speed = 1.0;
    std::optional<std::int64_t> seek_us;
    std::int64_t step_us = 0;
    std::optional<ViewSettings> settings;
  };
  template <class Change>
  void request(Change change);

  void run(const std::function<std::unique_ptr<Playback>()>& make);
  void apply_requests();
  void advance();
  void advance_to(std::int64_t t_us);
  void publish_snapshot();

  // Shared, under mutex_:
  std::mutex mutex_;
  std::condition_variable changed_;
  Requests requests_;
  bool ready_ = false;
  bool closing_ = false;
  std::exception_ptr failure_;
  std::optional<ViewSettings> kept_settings_;
  SnapshotChannel channel_;
  // Of the thread:
  std::unique_ptr<Playback> playback_;
  std::uint64_t applied_ = 0;  // number of the newest request that was applied
  bool playing_ = false;
  double speed_ = 1.0;
  std::optional<std::int64_t> seek_us_;
  std::string problem_;
  bool dirty_ = true;                   // the state differs from the last published snapshot
  WallClock::time_point next_publish_;  // while playing: snapshots get a third of the time at most
  double reached_speed_ = 0.0;
  struct TimePair {
    WallClock::time_point wall;
    std::int64_t t_us;
  };
  std::optional<TimePair> pace_;      // from where on time runs at speed_
  std::optional<TimePair> measured_;  // from where on reached_speed_ is measured
  // Written before ready_:
  ViewSettings first_settings_;
  std::vector<float> event_counts_;
  std::thread thread_;
};

}  // namespace saccade
