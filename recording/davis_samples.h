#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/event.h"
#include "recording/other_records.h"

namespace saccade {

/// The ranges of a DAVIS's inertial unit, which jAER writes among the preferences in the header of AEDAT 2.0: keys
/// `ImuAccelScale` and `ImuGyroScale`, in newer versions `CHIP.IMU.AccelScale` and `CHIP.IMU.GyroScale`, which count more. Where
/// they are missing, jAER's defaults: 8 g and 1000 deg/s. Sources: ImuControl.java of SensorsINI/jaer; MPU-6150's data sheet.
class InertialRanges {
 public:
  /// A line of the header. `chip`: the header's `AEChip`.
  void read(std::string_view line, std::string_view chip);

  [[nodiscard]] double values_per_g() const { return acceleration_.values_per_unit; }
  [[nodiscard]] double values_per_deg_s() const { return rotation_.values_per_unit; }
  /// The ranges that the header does not have, as "8 g and 1000 deg/s"; empty where it has both.
  [[nodiscard]] std::string missing() const;

 private:
  struct Range {
    std::string_view text;
    double values_per_unit;
    int source = 0;  ///< 0 the default, 1 older keys, 2 newer ones
  };
  Range acceleration_{"8 g", 4096.0};
  Range rotation_{"1000 deg/s", 32.8};
};

/// Frames, inertial readings and triggers of a DAVIS from the records of AEDAT 2.0 that are no events
/// (recording/aedat2_layout.h).
///
/// Sample of a frame: bit 31, y bits 22-30 from the bottom, x bits 12-21 from the left, bits 10-11 0 for the reset level and
/// 1 for the signal, bits 0-9 the converted value. A pixel's brightness is its reset level less its signal, 0 at least. A frame is
/// over when every pixel has both; one in which a pixel's level comes again before is incomplete and left out. Sample of the
/// inertial unit: bits 31, 11 and 10, quantity bits 28-30 (acceleration x, y, z, temperature, rotation x, y, z), value 16
/// signed bits from bit 12 on. Trigger: bit 10 without bit 31, in bits 0-2 its edge: 2 falling, 3 rising, 4 pulse, else
/// unknown. Source: DavisChip.java, DavisBaseCamera.java and IMUSample.java of SensorsINI/jaer.
class DavisSamples {
 public:
  /// `others`: null where nobody wants them.
  DavisSamples(OtherRecords* others, ImageSize size, const InertialRanges& ranges);

  /// Takes a record that is no event. False where nobody wants it.
  bool add(std::uint32_t address, std::int64_t t_us);

  /// With the one that has begun, if any.
  [[nodiscard]] std::int64_t incomplete_frames() const { return incomplete_frames_ + (frame_begun_ ? 1 : 0); }
  [[nodiscard]] bool has_inertial() const { return has_inertial_; }

 private:
  /// Which of a pixel's two levels are there.
  enum Level : std::uint8_t { reset_there = 1, signal_there = 2 };

  void add_frame_sample(std::uint32_t address, std::int64_t t_us);
  void add_inertial_sample(std::uint32_t address, std::int64_t t_us);
  void begin_frame(std::int64_t t_us);

  OtherRecords* others_;
  InertialRanges ranges_;
  bool frames_ = false, inertial_ = false, triggers_ = false;  ///< wanted
  ImageSize size_;
  std::vector<std::uint8_t> there_;  ///< levels, by pixel from the top left; empty before the first sample
  std::vector<std::uint16_t> reset_, signal_, pixels_;
  std::size_t whole_pixels_ = 0;
  bool frame_begun_ = false;
  std::int64_t frame_begin_us_ = 0;
  std::int64_t incomplete_frames_ = 0;  ///< left out
  std::array<std::int16_t, 7> quantities_{};
  unsigned quantities_there_ = 0;  ///< bits
  bool has_inertial_ = false;
};

}  // namespace saccade
