#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/detector.h"
#include "recording/event_file.h"
#include "recording/joints_source.h"
#include "recording/run_files.h"
#include "robot/robot.h"

namespace saccade {

/// Throws InputError where more than a day passes from one event to the next: a wrong time stamp, or stamps of two clocks. A
/// loop through it would take minutes to years. `where` names the recording.
void check_event_gap(const std::string& where, std::int64_t last_us, std::int64_t next_us);

/// Joints of a recording (joints.csv of a run folder, or a log of the robot's head), the limits of its head, and the
/// readings of its inertial measurement unit (imu.csv) if it has one.
struct RecordedHead {
  JointsSource joints;
  JointLimits limits;
  std::optional<TableReader<ImuRow>> imu = std::nullopt;
};

/// imu.csv of a run folder, where there is one. Throws InputError.
[[nodiscard]] std::optional<TableReader<ImuRow>> recorded_imu(const std::filesystem::path& folder);

/// Readings as recorded: read_imu() returns the newest row up to now; before the first row one of a head at rest.
class ReplayImu final : public ImuPort {
 public:
  explicit ReplayImu(TableReader<ImuRow> rows) : rows_(std::move(rows)), next_(rows_.next()) {}

  PortStatus read_imu(ImuReading& reading) override;
  void advance_to(std::int64_t now_us);
  void end() { status_ = PortStatus::ended; }

 private:
  TableReader<ImuRow> rows_;
  std::optional<ImuRow> next_;
  ImuReading reading_{0, Eigen::Vector3d::Zero(), Eigen::Vector3d(0.0, 0.0, 9.81)};
  PortStatus status_ = PortStatus::ok;
};

/// A head that moves as recorded: read() returns the newest row up to now, with the velocity between the last two rows.
/// Commands are checked against the limits, accepted, and have no effect.
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

/// Replays a recording as a robot, in fixed memory. Its clock jumps to any later time at once.
///
/// The clock starts at the first event, or with joints at their first row. One tick may reach beyond the last event (and
/// the last row); after it all ports have ended. Events that go back in time, lie outside the image, or come before the
/// first row of joints are left out and counted. Throws InputError where the recording does, and at a gap between events of more
/// than a day; the events before that place are delivered first.
class ReplayRobot final : public Robot, public Clock, public EventSource {
 public:
  /// Throws InputError if `events` has no image size.
  explicit ReplayRobot(std::unique_ptr<EventReader> events, std::optional<RecordedHead> head = std::nullopt);

  Clock& clock() override { return *this; }
  EventSource& events() override { return *this; }
  /// Null on a recording without joints.
  HeadPort* head() override { return head_ ? &*head_ : nullptr; }

  /// Null on a recording without imu.csv.
  ImuPort* imu() override { return imu_ ? &*imu_ : nullptr; }

  [[nodiscard]] std::int64_t now_us() const override { return now_us_; }
  PortStatus wait_until(std::int64_t t_us) override;

  [[nodiscard]] ImageSize image_size() const override { return image_size_; }
  PortStatus read_until(std::int64_t t_us, std::vector<Event>& events) override;
  [[nodiscard]] std::int64_t heard_us() const override { return now_us_; }
  [[nodiscard]] EventTraffic traffic() const override;

  /// Events that go back in time or lie outside the image.
  [[nodiscard]] RejectedEvents rejected() const { return rejected_; }
  /// Events before the first row of joints, which are not among rejected().
  [[nodiscard]] std::int64_t events_before_start() const { return events_before_start_; }

 private:
  const Event* next();
  bool is_over();

  std::unique_ptr<EventReader> reader_;
  std::optional<ReplayHead> head_;
  std::optional<ReplayImu> imu_;
  ImageSize image_size_;
  std::vector<Event> block_;
  std::size_t position_ = 0;  ///< in block_
  std::int64_t now_us_ = 0;
  std::int64_t last_us_;  ///< stamp of the last event that was passed on
  bool ended_ = false;
  bool delivered_ = false;  ///< an event
  RejectedEvents rejected_;
  std::int64_t events_before_start_ = 0;
};

}  // namespace saccade
