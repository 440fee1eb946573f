#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include "recording/run_files.h"

namespace saccade {

/// The joints of a recording, row by row: from joints.csv, or from a log of the robot's head.
class JointsSource {
 public:
  using Next = std::function<std::optional<JointsRow>()>;

  /// `next` returns the rows one by one, sorted by time, and none at the end.
  explicit JointsSource(Next next) : next_(std::move(next)) {}
  JointsSource(TableReader<JointsRow> table)  // NOLINT: a table is such a source
      : next_([rows = std::make_shared<TableReader<JointsRow>>(std::move(table))] { return rows->next(); }) {}

  /// None at the end. Throws InputError where the file is broken.
  [[nodiscard]] std::optional<JointsRow> next() { return next_(); }

 private:
  Next next_;
};

/// Whether a file of joints is the log of a data dumper, and no table joints.csv. Throws InputError for a missing file.
[[nodiscard]] bool is_head_log(const std::filesystem::path& path);

/// The log that a YARP data dumper (yarpdatadumper) writes of the head's state port, /icub/head/state:o, text lines of
///
///     12 1571751370.660680 -3.2 0.1 4.5 -1.0 2.5 5.0
///
/// the number of the packet, the host's time in s, or two of them (the sender's and the receiver's; the last one counts),
/// and the joints neck pitch, neck roll, neck yaw, eyes tilt, version and vergence in degrees. The torso's joints are 0.
/// `host_ahead_us`: the host's clock minus the events' clock; it is subtracted. next() throws InputError with file and
/// line for another content, and for time that goes back.
[[nodiscard]] JointsSource open_head_log(const std::filesystem::path& path, std::int64_t host_ahead_us);

/// The rows of `joints` from the last one on that is not later than `t_us`, or all where none is that early.
[[nodiscard]] JointsSource joints_from(JointsSource joints, std::int64_t t_us);

}  // namespace saccade
