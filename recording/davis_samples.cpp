#include "recording/davis_samples.h"

#include <algorithm>
#include <span>

#include "core/units.h"
#include "recording/aedat2_layout.h"

namespace saccade {
namespace {

constexpr std::uint32_t value_bits = 0x3ff;
constexpr unsigned value_shift = 6;  ///< 10 bits become the upper ones of 16
constexpr double temperatures_per_deg = 340.0;
constexpr double temperature_of_0_deg_c = 35.0;

TriggerKind kind_of(std::uint32_t address) {
  switch (address & 7u) {
    case 2:
      return TriggerKind::falling;
    case 3:
      return TriggerKind::rising;
    case 4:
      return TriggerKind::pulse;
    default:
      return TriggerKind::unknown;
  }
}

struct RangeName {
  std::string_view name;  ///< jAER's
  std::string_view text;
  double values_per_unit;
};
constexpr std::array<RangeName, 4> acceleration_ranges = {{{"ImuAccelScaleG2", "2 g", 16384.0},
                                                           {"ImuAccelScaleG4", "4 g", 8192.0},
                                                           {"ImuAccelScaleG8", "8 g", 4096.0},
                                                           {"ImuAccelScaleG16", "16 g", 2048.0}}};
constexpr std::array<RangeName, 4> rotation_ranges = {{{"GyroFullScaleDegPerSec250", "250 deg/s", 131.0},
                                                       {"GyroFullScaleDegPerSec500", "500 deg/s", 65.5},
                                                       {"GyroFullScaleDegPerSec1000", "1000 deg/s", 32.8},
                                                       {"GyroFullScaleDegPerSec2000", "2000 deg/s", 16.4}}};

/// What stands between `before` and the next quotation mark; empty where it does not.
std::string_view quoted(std::string_view line, std::string_view before) {
  const std::size_t begin = line.find(before);
  if (begin == std::string_view::npos) return {};
  line.remove_prefix(begin + before.size());
  return line.substr(0, line.find('"'));
}

}  // namespace

void InertialRanges::read(std::string_view line, std::string_view chip) {
  const std::string_view key = quoted(line, "key=\"");
  const std::string_view value = quoted(line, "value=\"");
  const std::string prefix = std::string(chip.substr(chip.rfind('.') + 1)) + ".IMU.";
  const auto take = [&](std::string_view old_key, std::string_view new_key, std::span<const RangeName> ranges,
                        Range& range) {
    const int source = key == old_key                                                    ? 1
                       : key.starts_with(prefix) && key.substr(prefix.size()) == new_key ? 2
                                                                                         : 0;
    if (source <= range.source) return;
    const auto named = std::ranges::find(ranges, value, &RangeName::name);
    if (named != ranges.end()) range = {named->text, named->values_per_unit, source};
  };
  take("ImuAccelScale", "AccelScale", acceleration_ranges, acceleration_);
  take("ImuGyroScale", "GyroScale", rotation_ranges, rotation_);
}

std::string InertialRanges::missing() const {
  std::string text;
  for (const Range& range : {acceleration_, rotation_})
    if (range.source == 0) text += (text.empty() ? "" : " and ") + std::string(range.text);
  return text;
}

DavisSamples::DavisSamples(OtherRecords* others, ImageSize size, const InertialRanges& ranges)
    : others_(others), ranges_(ranges), size_(size) {
  if (others == nullptr) return;
  frames_ = others->wants_frames();
  inertial_ = others->wants_inertial();
  triggers_ = others->wants_triggers();
}

bool DavisSamples::add(std::uint32_t address, std::int64_t t_us) {
  if ((address & Davis::sample) == 0) {
    if (triggers_) others_->add(RecordedTrigger{t_us, 0, kind_of(address), "DAVIS"});
    return triggers_;
  }
  if ((address & Davis::imu_sample) == Davis::imu_sample) {
    if (inertial_) add_inertial_sample(address, t_us);
    return inertial_;
  }
  if (frames_) add_frame_sample(address, t_us);
  return frames_;
}

void DavisSamples::begin_frame(std::int64_t t_us) {
  const auto pixels = static_cast<std::size_t>(size_.width) * static_cast<std::size_t>(size_.height);
  there_.assign(pixels, 0);
  reset_.resize(pixels);
  signal_.resize(pixels);
  whole_pixels_ = 0;
  frame_begun_ = true;
  frame_begin_us_ = t_us;
}

void DavisSamples::add_frame_sample(std::uint32_t address, std::int64_t t_us) {
  const std::uint32_t cycle = address >> 10 & 3u;
  const auto x = static_cast<int>(Davis::x(address));
  const int y = size_.height - 1 - static_cast<int>(Davis::y(address));
  if (cycle > 1 || !size_.contains(x, y)) return;
  const auto level = cycle == 0 ? reset_there : signal_there;
  const auto pixel =
      static_cast<std::size_t>(y) * static_cast<std::size_t>(size_.width) + static_cast<std::size_t>(x);
  if (frame_begun_ && (there_[pixel] & level) != 0) {
    ++incomplete_frames_;
    frame_begun_ = false;
  }
  if (!frame_begun_) begin_frame(t_us);
  (cycle == 0 ? reset_ : signal_)[pixel] = static_cast<std::uint16_t>(address & value_bits);
  there_[pixel] = static_cast<std::uint8_t>(there_[pixel] | level);
  if (there_[pixel] != (reset_there | signal_there) || ++whole_pixels_ < there_.size()) return;
  pixels_.resize(there_.size());
  for (std::size_t i = 0; i < pixels_.size(); ++i)
    pixels_[i] = static_cast<std::uint16_t>(std::max(reset_[i] - signal_[i], 0) << value_shift);
  RecordedFrame frame;
  frame.t_us = frame_begin_us_;
  frame.begin_us = frame_begin_us_;
  frame.end_us = t_us;
  frame.width = size_.width;
  frame.height = size_.height;
  frame.bits = 16;
  frame.pixels = std::as_bytes(std::span<const std::uint16_t>(pixels_));
  frame.source = "DAVIS";
  others_->add(frame);
  frame_begun_ = false;
}

void DavisSamples::add_inertial_sample(std::uint32_t address, std::int64_t t_us) {
  const std::uint32_t quantity = address >> 28 & 7u;
  if (quantity >= quantities_.size()) return;
  if (quantity == 0) quantities_there_ = 0;
  quantities_[quantity] = static_cast<std::int16_t>(address >> 12 & 0xffffu);
  quantities_there_ |= 1u << quantity;
  if (quantities_there_ != 0x7f) return;
  quantities_there_ = 0;
  has_inertial_ = true;
  InertialReading reading;
  reading.t_us = t_us;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    reading.acceleration_m_s2[axis] = quantities_[axis] / ranges_.values_per_g() * standard_gravity_m_s2;
    reading.angular_velocity_rad_s[axis] = quantities_[4 + axis] / ranges_.values_per_deg_s() * rad_per_deg;
  }
  reading.temperature_deg_c = quantities_[3] / temperatures_per_deg + temperature_of_0_deg_c;
  reading.source = "DAVIS";
  others_->add(reading);
}

}  // namespace saccade
