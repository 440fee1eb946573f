#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/event.h"
#include "head/head_state.h"
#include "head/imu_reading.h"
#include "robot/ports.h"

namespace saccade {

/// The frames between saccade and a robot in a program of its own, version 1; docs/external_robots.md describes them.
/// Little-endian. A frame: u32 type, u32 bytes of the payload, payload. Angles in rad, times in us of the robot's clock.
enum class RobotFrame : std::uint32_t {
  hello = 1,       ///< from the robot, first
  events = 2,      ///< from the robot; without events it shows that the camera is connected
  joints = 3,      ///< from the robot
  imu = 4,         ///< from the robot
  text = 5,        ///< from the robot: a line for the log
  end = 6,         ///< from the robot: it ends as planned
  client = 16,     ///< from saccade, first
  activate = 17,   ///< from saccade: the joints follow references of this number from now on
  reference = 18,  ///< from saccade
  stop = 19,       ///< from saccade: the joints hold where they are, until the next reference
  release = 20,    ///< from saccade: the joints hold and follow no references, whatever their number
  heartbeat = 21,  ///< from saccade
};

inline constexpr std::uint32_t robot_protocol = 1;
inline constexpr std::size_t frame_head_bytes = 8;
inline constexpr std::size_t most_frame_events = 65'535;
inline constexpr std::size_t most_payload_bytes = 8 + 16 * most_frame_events;
inline constexpr std::size_t most_text_bytes = 1000;
inline constexpr std::size_t joint_name_bytes = 32;
/// A head stops by itself after this time without a frame of the client that moves it: the range of RobotHello::watchdog_ms.
inline constexpr std::int64_t least_watchdog_ms = 20;
inline constexpr std::int64_t most_watchdog_ms = 100;

/// What a robot says of itself.
struct RobotHello {
  struct Joint {
    std::string name;  ///< 1 to 32 bytes
    double min_rad = 0.0, max_rad = 0.0, max_speed_rad_s = 0.0;
  };
  ImageSize image_size;
  std::int64_t now_us = 0;       ///< the robot's clock
  std::int64_t watchdog_ms = 0;  ///< the head stops by itself after this time without a frame of its client
  bool has_imu = false;
  int torso_joints = 0;  ///< the first of the joints, measured and not commanded
  std::vector<Joint> joints;
};

/// What moves or only stops the head.
enum class RobotClient : std::uint32_t { controller = 1, guard = 2 };

/// A reading of the joints, in the order of the hello.
struct JointsFrame {
  static constexpr int most_joints = joint_slots;
  std::int64_t t_us = 0;
  std::uint64_t activation = 0;  ///< whose references the joints follow; 0: none
  int count = 0;
  std::array<double, most_joints> position_rad{}, velocity_rad_s{};
  std::array<JointDrive, most_joints> drive{};
};

/// A frame of which the payload lies elsewhere.
struct FrameView {
  RobotFrame type{};
  std::span<const std::byte> payload;
};

/// Cuts a stream of bytes into frames. Memory: at most one frame and one block of what was received.
class FrameReader {
 public:
  /// Where the next bytes may be received.
  [[nodiscard]] std::span<std::byte> room();
  void received(std::size_t bytes) { end_ += bytes; }
  /// The next whole frame, valid until room(). After a frame that is too long there is none, and problem() is not empty.
  [[nodiscard]] std::optional<FrameView> next();
  [[nodiscard]] const std::string& problem() const { return problem_; }

 private:
  std::vector<std::byte> bytes_;
  std::size_t begin_ = 0, end_ = 0;
  std::string problem_;
};

/// Appends a frame to `out`. Values that the receiver rejects are written as they are.
void write_hello(const RobotHello& hello, std::vector<std::byte>& out);
/// At most most_frame_events events. `until_us`: every event up to then was sent.
void write_events(std::int64_t until_us, std::span<const Event> events, std::vector<std::byte>& out);
void write_joints(const JointsFrame& joints, std::vector<std::byte>& out);
void write_imu(const ImuReading& reading, std::vector<std::byte>& out);
void write_text(std::string_view text, std::vector<std::byte>& out);
void write_client(RobotClient client, std::vector<std::byte>& out);
void write_reference(std::uint64_t activation, std::span<const double> reference_rad,
                     std::vector<std::byte>& out);
/// activate, stop, release, heartbeat: with the number of the activation. end: without payload.
void write_number(RobotFrame type, std::uint64_t activation, std::vector<std::byte>& out);
void write_end(std::vector<std::byte>& out);

/// Each returns an empty text, or what is wrong: "joints: found 40 bytes, expected 64".
[[nodiscard]] std::string read_hello(std::span<const std::byte> payload, RobotHello& hello);
[[nodiscard]] std::string read_events(std::span<const std::byte> payload, std::int64_t& until_us,
                                      std::vector<Event>& events);
/// `count`: the number of joints of the hello.
[[nodiscard]] std::string read_joints(std::span<const std::byte> payload, int count, JointsFrame& joints);
[[nodiscard]] std::string read_imu(std::span<const std::byte> payload, ImuReading& reading);
/// Printable characters of the text; others become '?'.
[[nodiscard]] std::string read_text(std::span<const std::byte> payload, std::string& text);
[[nodiscard]] std::string read_client(std::span<const std::byte> payload, RobotClient& client);
[[nodiscard]] std::string read_reference(std::span<const std::byte> payload, int count,
                                         std::uint64_t& activation,
                                         std::array<double, gaze_slots>& reference_rad);
[[nodiscard]] std::string read_number(std::span<const std::byte> payload, std::uint64_t& activation);

}  // namespace saccade
