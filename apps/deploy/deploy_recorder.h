#pragma once

#include <atomic>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "apps/deploy/black_box.h"
#include "apps/deploy/deploy_session.h"
#include "apps/deploy/recording_files.h"
#include "apps/deploy/spsc_ring.h"
#include "apps/deploy/time_figures.h"
#include "config/robot_file.h"
#include "loop/run_log.h"
#include "recording/run_files.h"
#include "session/failure_log.h"
#include "session/log_file.h"
#include "session/observations.h"

namespace saccade {

/// Facts about a deployed run for its summary.
struct DeployFacts {
  std::vector<StartUpCheck> checks;
  bool dry_run = false;
  bool record = false;  ///< events and joints are recorded too
};

/// A detector or a gaze controller in a program of its own that ended during a run.
struct EndedProgram {
  std::int64_t t_us = 0;
  std::string what;  ///< "detector mine" or "gaze controller"
  std::string why;
};

/// Records a deployed run: writes its run folder tick by tick, and log and figures to standard error (on a terminal one
/// changing line five times per second, else a line per second).
///
/// A thread of its own writes files and terminal; ticks pass their data to it through rings of fixed size (4096 ticks,
/// 2^19 events). If the thread falls behind and a ring is full, ticks or events are dropped from the files and counted;
/// tick timing is not affected. If a table cannot be written, the tables end, the run continues, and finish() throws; every second they are put on the
/// disk, and what is there remains with the ending .part. With less room than output.least_free_mb they end, too. The
/// last seconds are in a BlackBox at any time, recorded events in RecordingFiles.
class DeployRecorder final : public DeployObserver {
 public:
  /// `robot` and `loop` outlive it. The folder exists.
  DeployRecorder(std::filesystem::path folder, const RobotFile& robot, const Loop& loop, ImageSize image,
                 DeployFacts facts);
  DeployRecorder(const DeployRecorder&) = delete;
  DeployRecorder& operator=(const DeployRecorder&) = delete;
  ~DeployRecorder() override;

  void on_tick(const Tick& tick, const TickTiming& timing) override;
  void on_change(const DeployChange& change) override;
  void on_news(std::int64_t t_us, const std::string& line) override;
  /// RealTime::summary(), for the summary.
  void set_scheduling(std::string summary) { scheduling_ = std::move(summary); }
  /// After the last tick: writes what is left, metrics.json and deploy.json. Throws RunError, InputError.
  void finish();
  /// In the order in which they ended; from the thread of the ticks, or after finish().
  [[nodiscard]] const std::vector<EndedProgram>& ended() const { return ended_; }

 private:
  struct Slot {
    Tick tick;
    TickTiming timing;
    std::vector<DetectorTick> detectors;
    std::size_t events = 0;  ///< of the tick, in the ring of events
  };
  struct Detections {
    std::int64_t at_threshold = 0;  ///< observations at or above the threshold
    std::int64_t skipped = 0;
    std::int64_t elapsed_ns = 0;
    std::int64_t in_window = 0;  ///< of them, since the last status line
  };
  struct Figures {
    TimeFigures late, tick, latency;
    std::int64_t tick_sum_us = 0;
    std::int64_t latency_sum_us = 0;
    std::int64_t missed = 0;
    std::int64_t events = 0;
    std::int64_t left_out = 0;
    std::int64_t skipped = 0;

    void add(const Slot& slot);
  };

  void work();
  bool drain();
  void write(Slot& slot);
  void record(const Tick& tick);
  /// Puts the tables on the disk, or ends them where it has too little room.
  void sync_tables(std::int64_t t_us);
  void commit_tables();
  void write_timing();
  void show_status();
  void print_line(const std::string& line);
  void write_summary(bool tables_ended_early) const;

  std::filesystem::path folder_;
  const RobotFile& robot_;
  const Loop& loop_;
  ImageSize image_;
  DeployFacts facts_;
  std::string scheduling_;

  SpscRing<Slot> ticks_;
  SpscRing<Event> event_ring_;
  std::atomic<std::int64_t> lost_ticks_ = 0;
  std::atomic<std::int64_t> lost_events_ = 0;
  std::mutex changes_mutex_;
  std::vector<DeployChange> changes_;
  std::vector<std::pair<std::int64_t, std::string>> new_lines_;
  std::vector<EndedProgram> ended_;
  FailureLog failures_;
  std::atomic<bool> over_ = false;

  // From here on used by the writer's thread alone until it is joined.
  bool terminal_;
  bool line_is_open_ = false;
  LogFile log_file_;
  RunLog log_;
  Observations observations_;
  TableWriter<DetectionRow> detections_;
  TableWriter<GazeRow> gaze_;
  TableWriter<TimingRow> timing_;
  BlackBox black_box_;
  std::optional<RecordingFiles> recording_;
  std::vector<Event> tick_events_;
  std::vector<Detections> detectors_;
  MicrosecondHistogram late_histogram_, tick_histogram_;
  Figures whole_, timing_window_, status_window_;
  std::int64_t ticks_in_window_ = 0;  // of the status line
  TickTiming last_;
  std::optional<Eigen::Vector3d> target_m_;
  GazePhase phase_ = GazePhase::none;
  std::int64_t unflushed_ = 0;  // ticks
  std::int64_t unguarded_ = 0;  // ticks of the active head
  std::int64_t queued_most_ = 0;
  std::int64_t last_joints_us_;
  std::optional<std::int64_t> start_us_;
  std::int64_t next_timing_us_ = 0;
  std::int64_t next_status_us_ = 0;
  std::int64_t next_sync_us_ = 0;
  bool tables_ended_ = false;
  std::string failure_;
  std::thread writer_;
};

}  // namespace saccade
