#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "core/event.h"

namespace saccade {

// Where pixel, polarity and camera are in an address of AEDAT 2.0 or 1.0. x and y are counted from the bottom right.
// `no_event`: bits that are set in records that are no events; `unused`: bits that no record of this layout sets.

/// DVS128: polarity bit 0 (0 = ON), x bits 1-7, y bits 8-14; bits 15 and 31 are special events.
struct Dvs128 {
  static constexpr std::uint32_t no_event = 1u << 31 | 1u << 15;
  static constexpr std::uint32_t unused = 0x7fff'0000;
  static std::uint8_t camera(std::uint32_t) { return 0; }
  static std::uint32_t x(std::uint32_t address) { return address >> 1 & 0x7f; }
  static std::uint32_t y(std::uint32_t address) { return address >> 8 & 0x7f; }
  static bool on(std::uint32_t address) { return (address & 1) == 0; }
  static std::uint32_t address(std::uint32_t x, std::uint32_t y, bool on) {
    return y << 8 | x << 1 | (on ? 0u : 1u);
  }
};

/// jAER's DVS128StereoPair: two DVS128, bit 15 is the right eye's.
struct StereoPair : Dvs128 {
  static constexpr std::uint32_t right = 1u << 15;
  static constexpr std::uint32_t no_event = 1u << 31;
  static std::uint8_t camera(std::uint32_t address) { return (address & right) != 0 ? 1 : 0; }
};

/// jAER's DVS640, which v2e writes for 640x480: polarity bit 0 (1 = ON), x bits 1-10, y bits 11-20.
struct Dvs640 {
  static constexpr std::uint32_t no_event = 1u << 31;
  static constexpr std::uint32_t unused = 0x7fe0'0000;
  static std::uint8_t camera(std::uint32_t) { return 0; }
  static std::uint32_t x(std::uint32_t address) { return address >> 1 & 0x3ff; }
  static std::uint32_t y(std::uint32_t address) { return address >> 11 & 0x3ff; }
  static bool on(std::uint32_t address) { return (address & 1) != 0; }
};

/// DAVIS: polarity bit 11 (1 = ON), x bits 12-21, y bits 22-30; bit 10 is a special event; with bit 31 the record is an APS
/// sample, or one value of an IMU sample where bits 10 and 11 are set too.
struct Davis {
  static constexpr std::uint32_t sample = 1u << 31;
  static constexpr std::uint32_t imu_sample = sample | 3u << 10;
  static constexpr std::uint32_t special = 1u << 10;
  static constexpr std::uint32_t no_event = sample | special;
  static constexpr std::uint32_t unused = 0;
  static std::uint8_t camera(std::uint32_t) { return 0; }
  static std::uint32_t x(std::uint32_t address) { return address >> 12 & 0x3ff; }
  static std::uint32_t y(std::uint32_t address) { return address >> 22 & 0x1ff; }
  static bool on(std::uint32_t address) { return (address >> 11 & 1) != 0; }
  static std::uint32_t address(std::uint32_t x, std::uint32_t y, bool on) {
    return y << 22 | x << 12 | (on ? 1u : 0u) << 11;
  }
};

/// The largest images that the layouts hold.
inline constexpr ImageSize dvs640_largest{1024, 1024};
inline constexpr ImageSize davis_largest{1024, 512};

/// What the addresses of all records of a file say of its layout and image size.
class Aedat2Survey {
 public:
  /// `records`: whole records of AEDAT 2.0.
  void add(std::string_view records);

  /// "dvs128", "dvs640" or "davis": the one that the fewest records contradict. Of layouts that fit equally well, the one
  /// that images of `size` have, else the one of the smallest image.
  [[nodiscard]] std::string_view layout(std::optional<ImageSize> size) const;
  /// The DAVIS whose image the events show: the smallest one that has all their pixels. None where a larger one has them
  /// as well: no event is in the smallest image's last column and row, or hardly any lies outside the next smaller image.
  [[nodiscard]] std::optional<ImageSize> davis_size() const;
  /// The smallest image that has all pixels of a DAVIS's events.
  [[nodiscard]] ImageSize davis_reach() const { return reach_; }

 private:
  std::int64_t not_dvs128_ = 0, not_dvs640_ = 0, not_davis_ = 0;  ///< records
  std::int64_t davis_events_ = 0;
  std::array<std::int64_t, 3> outside_{};  ///< events outside the images of aedat_davis_sizes
  ImageSize reach_{0, 0};
  ImageSize sensor_reach_{0, 0};  ///< without pixels that no DAVIS has
};

}  // namespace saccade
