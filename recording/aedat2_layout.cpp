#include "recording/aedat2_layout.h"

#include <algorithm>

#include "recording/aedat_chip.h"
#include "recording/byte_order.h"

namespace saccade {
namespace {

constexpr std::size_t survey_record_bytes = 8;
constexpr std::uint32_t davis_low_bits = 0x3ff;  ///< 0 in events of a DAVIS
constexpr std::int64_t few = 1000;               ///< fewer than one in so many events are outliers

ImageSize with_pixel(ImageSize reach, std::uint32_t x, std::uint32_t y) {
  return {std::max(reach.width, static_cast<int>(x) + 1), std::max(reach.height, static_cast<int>(y) + 1)};
}

}  // namespace

void Aedat2Survey::add(std::string_view records) {
  for (; records.size() >= survey_record_bytes; records.remove_prefix(survey_record_bytes)) {
    const auto address = load_big<std::uint32_t>(records.data());
    const bool is_sample = (address & Davis::sample) != 0;
    const bool is_pixel_of_640 =
        (address & Dvs640::unused) == 0 && aedat_dvs640_size.contains(static_cast<int>(Dvs640::x(address)),
                                                                      static_cast<int>(Dvs640::y(address)));
    not_dvs128_ += is_sample || (address & Dvs128::unused) != 0 ? 1 : 0;
    not_dvs640_ += is_sample || !is_pixel_of_640 ? 1 : 0;
    not_davis_ += !is_sample && (address & davis_low_bits) != 0 ? 1 : 0;
    if ((address & Davis::no_event) != 0) continue;
    ++davis_events_;
    const std::uint32_t x = Davis::x(address);
    const std::uint32_t y = Davis::y(address);
    reach_ = with_pixel(reach_, x, y);
    for (std::size_t i = 0; i < outside_.size(); ++i) {
      const bool inside = aedat_davis_sizes[i].contains(static_cast<int>(x), static_cast<int>(y));
      outside_[i] += inside ? 0 : 1;
      if (inside && i + 1 == outside_.size()) sensor_reach_ = with_pixel(sensor_reach_, x, y);
    }
  }
}

std::string_view Aedat2Survey::layout(std::optional<ImageSize> size) const {
  struct Candidate {
    std::string_view name;
    std::int64_t misfits;
    bool of_size;
  };
  std::array<Candidate, 3> candidates = {{{"dvs128", not_dvs128_, size == aedat_dvs128_size},
                                          {"dvs640", not_dvs640_, size == aedat_dvs640_size},
                                          {"davis", not_davis_, size.has_value()}}};
  return std::ranges::min_element(candidates,
                                  [](const Candidate& a, const Candidate& b) {
                                    return a.misfits != b.misfits ? a.misfits < b.misfits
                                                                  : a.of_size && !b.of_size;
                                  })
      ->name;
}

std::optional<ImageSize> Aedat2Survey::davis_size() const {
  const std::int64_t no_sensors = outside_.back();
  if (davis_events_ == 0 || no_sensors * few > davis_events_) return std::nullopt;
  for (std::size_t i = 0; i < outside_.size(); ++i) {
    if (outside_[i] > no_sensors) continue;
    if (i == 0) {
      const bool is_full = sensor_reach_ == aedat_davis_sizes[0];
      return is_full ? std::optional(aedat_davis_sizes[0]) : std::nullopt;
    }
    const std::int64_t beyond_smaller = outside_[i - 1] - no_sensors;
    return beyond_smaller * few >= davis_events_ ? std::optional(aedat_davis_sizes[i]) : std::nullopt;
  }
  return std::nullopt;
}

}  // namespace saccade
