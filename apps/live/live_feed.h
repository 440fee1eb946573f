#pragma once

#include <Eigen/Core>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "apps/live/live_server.h"
#include "core/camera.h"
#include "core/event.h"
#include "head/head_model.h"
#include "loop/loop.h"

namespace saccade {

/// A row of the page's table of watchdogs: a column of the stream, and the bound that stops the head.
struct LiveBound {
  std::string name;
  std::string column;
  double bound_ms = 0.0;
};

/// What a live page says of a run before its first tick.
struct LiveRun {
  std::string title;
  std::string kind;  ///< run, detect, serve or deploy
  ImageSize size;
  bool both_eyes = false;
  std::optional<double> duration_s = {};
  std::shared_ptr<const HeadModel> head = {};        ///< whose joints are shown; null: none
  std::optional<Eigen::Vector2d> principal_px = {};  ///< where the optical axis is in the image
  bool can_stop = false;                             ///< whether the page offers to stop the head
  std::vector<LiveBound> watchdogs = {};
};

/// What a simulation knows of the tick that comes next.
struct LiveTruth {
  std::optional<Circle> circle;
  double visible = 0.0;
  std::optional<double> gaze_error_deg;
  std::optional<Eigen::Vector2d> target_px;  ///< the gaze target in the image
};

/// A tick of a deployed run, ms, and what its watchdogs look at.
struct LiveTiming {
  double late_ms = 0.0;
  double tick_ms = 0.0;
  std::optional<double> latency_ms;
  double camera_age_ms = 0.0;           ///< since the newest packet
  std::optional<double> joints_age_ms;  ///< since the newest reading; none without a head
  std::int64_t skipped_ticks = 0;       ///< since the start, as the next one
  std::int64_t dropped_events = 0;
  bool guarded = true;
};

/// The page of one run (docs/live.md): hands each tick over to a thread that sends what has come to the server's clients, 30
/// times per second. A tick is copied into memory that was made before; where that is full, or in use at that moment, the
/// page misses what came. While nobody looks nothing is copied. on_tick(), set_truth() and set_timing() neither wait nor
/// allocate.
class LiveFeed final : public LoopObserver {
 public:
  /// `server` outlives it. `loop`: whose detectors are shown.
  LiveFeed(LiveServer& server, LiveRun run, const Loop& loop);
  LiveFeed(const LiveFeed&) = delete;
  LiveFeed& operator=(const LiveFeed&) = delete;
  ~LiveFeed() override;

  /// Before on_tick(), in its thread.
  void set_truth(const LiveTruth& truth) { truth_ = truth; }
  void set_timing(const LiveTiming& timing) { timing_ = timing; }
  void on_tick(const Tick& tick) override;

  /// A word for the state, and whether it needs attention; in the thread of the ticks. Does not wait; may allocate.
  void set_state(std::string_view state, bool alarm);
  /// A line of the log, in the same thread. Does not wait; may allocate.
  void add_line(std::int64_t t_us, std::string_view line);

  /// Events and ticks that the page has missed.
  [[nodiscard]] std::uint64_t missed() const { return missed_; }

 private:
  struct Detection {
    std::size_t detector = 0;
    std::int64_t t_us = 0;
    Circle circle;
    double score = 0.0;
    bool held = false;
  };
  struct Instant {
    std::int64_t t_us = 0;
    bool has_head = false;
    JointVector position_rad = JointVector::Zero();
    LiveTruth truth;
    std::optional<LiveTiming> timing;
  };
  struct Batch {
    std::vector<Event> events;
    std::vector<Detection> detections;
    std::vector<Instant> instants;
    std::vector<std::string> lines;
    std::string state;
    bool alarm = false;
  };

  void run();
  void hand_over_text(Batch& batch);
  void send(const Batch& batch);
  [[nodiscard]] std::string greeting() const;

  LiveServer& server_;
  LiveRun run_;
  std::vector<std::pair<std::string, double>> detectors_;  // names, thresholds
  LiveTruth truth_;                                        // these in the thread of the ticks alone
  std::optional<LiveTiming> timing_;
  std::string state_;
  bool alarm_ = false;
  std::vector<std::string> new_lines_;
  std::atomic<std::uint64_t> missed_ = 0;
  std::mutex mutex_;  // of filling_; the thread of the ticks never waits for it
  std::unique_ptr<Batch> filling_;
  std::unique_ptr<Batch> sending_;
  static constexpr std::int64_t not_started = std::numeric_limits<std::int64_t>::min();
  std::atomic<std::int64_t> start_us_ = not_started;  // of the first tick
  std::deque<std::string> lines_;                     // in the thread that sends alone
  std::mutex end_mutex_;
  std::condition_variable end_;
  bool over_ = false;
  std::thread thread_;
};

}  // namespace saccade
