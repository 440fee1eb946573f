#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace saccade {

// What a recording holds besides events. Times are in us of the clock of the events, if the file has one clock.

/// An image of a conventional camera.
struct RecordedFrame {
  std::int64_t t_us = 0;  ///< as the file has it
  /// Begin and end of the exposure, of AEDAT 2.0 times of the first and the last sample; none where the file has none.
  std::optional<std::int64_t> begin_us, end_us;
  int width = 0, height = 0;
  int x = 0, y = 0;  ///< of its top left pixel on the sensor
  int channels = 1;  ///< 1 grey, 3 BGR or 4 BGRA
  int bits = 8;      ///< of a channel: 8 or 16
  /// Row by row from the top left, 16 bits in the order of this machine. Empty where `encoded` is not.
  std::span<const std::byte> pixels;
  std::string_view encoded;    ///< a whole image file, as the recording has it
  std::string_view extension;  ///< of `encoded`: ".png" or ".jpg"
  std::string_view source;     ///< camera, stream or topic
};

/// A reading of an inertial unit, in its own axes.
struct InertialReading {
  std::int64_t t_us = 0;
  std::array<double, 3> acceleration_m_s2{};  ///< at rest 1 g upwards
  std::array<double, 3> angular_velocity_rad_s{};
  std::optional<double> temperature_deg_c;
  std::string_view source;
};

enum class TriggerKind : std::uint8_t {
  unknown,  ///< the file has no edge
  falling,
  rising,
  pulse,
  generator_rising,
  generator_falling,
  reset,  ///< the sensor's clock begins at 0 again
  frame_begin,
  frame_end,
  exposure_begin,
  exposure_end,
};
/// "rising"
[[nodiscard]] std::string_view text_of(TriggerKind kind);

struct RecordedTrigger {
  std::int64_t t_us = 0;
  int channel = 0;  ///< of the sensor; 0 where the format has none
  TriggerKind kind = TriggerKind::unknown;
  std::string_view source;
};

/// Takes what a reader finds besides events, in file order and before the events of the same read() or a later one. Views
/// are valid during the call only.
class OtherRecords {
 public:
  OtherRecords() = default;
  OtherRecords(const OtherRecords&) = delete;
  OtherRecords& operator=(const OtherRecords&) = delete;
  virtual ~OtherRecords() = default;

  /// What is not wanted is skipped and counted (EventReader::skipped()).
  [[nodiscard]] virtual bool wants_frames() const = 0;
  [[nodiscard]] virtual bool wants_inertial() const = 0;
  [[nodiscard]] virtual bool wants_triggers() const = 0;
  /// Each is called only where it is wanted. They throw RunError where they cannot keep it.
  virtual void add(const RecordedFrame& frame) = 0;
  virtual void add(const InertialReading& reading) = 0;
  virtual void add(const RecordedTrigger& trigger) = 0;
};

inline constexpr double standard_gravity_m_s2 = 9.80665;

}  // namespace saccade
