#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "apps/deploy/deploy_session.h"

namespace saccade {

/// The end of a deployed run, as text that is in the file system at any time: after any stop, and when the program is
/// killed, the folder `blackbox` of the run holds the last 10 to 20 s. Two files of each kind take turns, 10 s in each;
/// the newer one has the larger times.
///
/// - `ticks_0.csv`, `ticks_1.csv`: every tick: its timing, state, phase, joints, reference, target and the observations of
///   the first detector; columns as in the first line, empty where there is no value.
/// - `events_0.csv`, `events_1.csv`: t_us,x,y,p,camera of every event.
/// - `messages_0.txt`, `messages_1.txt`: the lines of the log.
///
/// What flush() wrote survives the end of the program. Once a second it is synced to the disk: a power cut loses the last
/// second. A file that cannot be written ends the black box, not the run.
class BlackBox {
 public:
  static constexpr std::int64_t turn_us = 10'000'000;

  /// Creates the folder and removes older files in it. Throws RunError.
  explicit BlackBox(std::filesystem::path folder, std::shared_ptr<const HeadModel> head = default_head());
  BlackBox(const BlackBox&) = delete;
  BlackBox& operator=(const BlackBox&) = delete;
  ~BlackBox();

  void add(const Tick& tick, const TickTiming& timing, std::span<const DetectorTick> detectors,
           std::span<const Event> events);
  void add(std::int64_t t_us, std::string_view message);
  /// Hands everything to the operating system.
  void flush();
  /// What went wrong; empty if nothing.
  [[nodiscard]] const std::string& failure() const { return failure_; }

 private:
  struct File {
    const char* name;
    const char* ending;
    std::string head;  ///< first line
    int descriptor = -1;
    std::string text = {};
  };

  void turn(std::int64_t t_us);
  void fail();

  std::filesystem::path folder_;
  std::shared_ptr<const HeadModel> head_;
  std::array<File, 3> files_;
  std::int64_t turned_us_ = INT64_MIN;
  std::int64_t synced_us_ = 0;
  std::int64_t newest_us_ = 0;
  int number_ = 1;
  std::string failure_;
};

}  // namespace saccade
