#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/detector.h"
#include "recording/event_file.h"
#include "recording/run_files.h"
#include "robot/ports.h"

namespace saccade {

/// The joints of a recording (joints.csv of a run folder) and the limits of the head that moved them.
struct RecordedHead {
  TableReader<JointsRow> joints;
  JointLimits limits;
};

/// A head that moves as it did: read() gives the newest row up to now, with the speed between the last two
/// rows; commands are checked against the limits, taken, and change nothing.
class ReplayHead final : public HeadPort {
 public:
  /// Throws InputError for a table without rows.
  explicit ReplayHead(RecordedHead recording);

  [[nodiscard]] JointLimits limits() const override { return recording_.limits; }
  PortStatus read(HeadState& state) override;
  CommandResult command(const HeadCommand& reference_rad) override;
  PortStatus stop() override { return status_; }

  void advance_to(std::int64_t now_us);
  void end() { status_ = PortStatus::ended; }
  [[nodiscard]] std::int64_t t_us() const { return state_.t_us; }
  [[nodiscard]] bool at_last_row() const { return !next_.has_value(); }

 private:
  RecordedHead recording_;
  HeadState state_;
  std::optional<JointsRow> next_;
  PortStatus status_ = PortStatus::ok;
};

/// Plays a recording as if it were a robot, in fixed memory. Time jumps where the loop wants it.
///
/// The clock starts at the first event, or with joints at their first row. A tick that reaches beyond the
/// last event (and the last row) still comes; after it, everything has ended. Events that come before an
/// earlier one in the file or before the start, and events outside the image, are left out and counted.
/// Throws InputError where the recording does; the events before that place have been appended by then.
class ReplayRobot final : public Clock, public EventSource {
 public:
  /// Throws InputError where `events` does not know its image size.
  explicit ReplayRobot(std::unique_ptr<EventReader> events, std::optional<RecordedHead> head = std::nullopt);

  [[nodiscard]] std::int64_t now_us() const override { return now_us_; }
  PortStatus wait_until(std::int64_t t_us) override;

  [[nodiscard]] ImageSize image_size() const override { return image_size_; }
  PortStatus read_until(std::int64_t t_us, std::vector<Event>& events) override;
  [[nodiscard]] std::int64_t heard_us() const override { return now_us_; }
  [[nodiscard]] EventTraffic traffic() const override;

  /// Null on a recording without joints.
  [[nodiscard]] HeadPort* head() { return head_ ? &*head_ : nullptr; }
  [[nodiscard]] RejectedEvents rejected() const { return rejected_; }

 private:
  const Event* next();
  bool is_over();

  std::unique_ptr<EventReader> reader_;
  std::optional<ReplayHead> head_;
  ImageSize image_size_;
  std::vector<Event> block_;
  std::size_t position_ = 0;  ///< in block_
  std::int64_t now_us_ = 0;
  std::int64_t last_us_;  ///< stamp of the last event that was passed on
  bool ended_ = false;
  RejectedEvents rejected_;
};

}  // namespace saccade
