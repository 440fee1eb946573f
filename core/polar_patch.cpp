#include "core/polar_patch.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/time_stamp.h"

namespace saccade::inline v0_1 {
namespace {

constexpr float pi = std::numbers::pi_v<float>;
constexpr double slowest_px_s = 4.0;  // motion that an event's weight falls by at least
constexpr float most_px = 16.0F;      // of motion since an event
constexpr float trail_px = 4.0F;      // looked at beyond the outermost ring
constexpr int most_half_width = 30;   // pixels looked at from the centre in each direction
constexpr float outline_ring = 7.0F;  // index of the ring on the outline

/// exp(-m / 2 px) and exp(-m / 8 px) by steps of 1/8 px.
struct Weights {
  static constexpr std::size_t steps = 129;
  std::array<std::array<float, 2>, steps> of{};
};
const Weights& weights() {
  static const Weights table = [] {
    Weights w;
    for (std::size_t i = 0; i < Weights::steps; ++i) {
      const double m = static_cast<double>(i) / 8.0;
      w.of[i] = {static_cast<float>(std::exp(-m / 2.0)), static_cast<float>(std::exp(-m / 8.0))};
    }
    return w;
  }();
  return table;
}

/// Angle of (x, y) in turns from 0 to 1, to 1e-4.
float turns(float x, float y) {
  const float ax = std::abs(x);
  const float ay = std::abs(y);
  const float a = std::min(ax, ay) / std::max(std::max(ax, ay), 1e-6F);
  const float s = a * a;
  float angle = a * (0.99535F + s * (-0.288679F + s * 0.0793F)) / (2.0F * pi);
  if (ay > ax) angle = 0.25F - angle;
  if (x < 0.0F) angle = 0.5F - angle;
  if (y < 0.0F) angle = 1.0F - angle;
  return angle;
}

/// Sums of weights by direction, ring (with one more inside and outside) and event channel.
class Splat {
 public:
  explicit Splat(float width_px) : per_width_(1.0F / width_px) {}

  /// Adds an event that the motion of `m_px` has carried to (x, y) from the centre; `off` from the outline.
  void add(float x, float y, float off_px, float m_px, std::size_t channel) {
    const float ring = off_px * per_width_ + (outline_ring + 1.0F);
    if (!(ring > 0.0F && ring < static_cast<float>(rings - 1))) return;
    const auto& w = weights().of[static_cast<std::size_t>(m_px * 8.0F)];
    const float direction = turns(x, y) * PolarPatch::directions;
    const auto d = static_cast<std::size_t>(direction);
    const auto r = static_cast<std::size_t>(ring);
    const float d_share = direction - static_cast<float>(d);
    const float r_share = ring - static_cast<float>(r);
    add_pair(at(d % PolarPatch::directions, r) + channel, 1.0F - d_share, r_share, w);
    add_pair(at((d + 1) % PolarPatch::directions, r) + channel, d_share, r_share, w);
  }
  [[nodiscard]] const float* of(std::size_t direction, std::size_t ring) const {
    return sums_.data() + (direction * rings + ring + 1) * channels;
  }

 private:
  static constexpr std::size_t rings = PolarPatch::rings + 2, channels = PolarPatch::event_channels;

  [[nodiscard]] float* at(std::size_t direction, std::size_t ring) {
    return sums_.data() + (direction * rings + ring) * channels;
  }
  static void add_pair(float* inner, float share, float outer_share, const std::array<float, 2>& w) {
    float* outer = inner + channels;
    const float to_outer = share * outer_share;
    const float to_inner = share - to_outer;
    inner[0] += to_inner * w[0];
    inner[1] += to_inner * w[1];
    outer[0] += to_outer * w[0];
    outer[1] += to_outer * w[1];
  }

  std::array<float, PolarPatch::directions * rings * channels> sums_{};
  float per_width_;
};

std::int64_t horizon_us(double speed_px_s) {
  return static_cast<std::int64_t>(static_cast<double>(most_px) / std::max(speed_px_s, slowest_px_s) * 1e6);
}

float log_speed(double px_s) { return static_cast<float>(std::log1p(px_s)); }

}  // namespace

PolarPatch polar_patch(std::span<const std::int64_t> newest_us, ImageSize size, const Circle& circle,
                       const PatchMotion& motion, std::int64_t now_us) {
  PolarPatch patch;
  const double disc_px_s = motion.disc_px_s.norm();
  const double background_px_s = motion.background_px_s.norm();
  patch.ring_px = polar_ring_px(circle.r_px);
  const auto width_px = static_cast<float>(patch.ring_px);
  const auto radius = static_cast<float>(circle.r_px);
  const auto cx = static_cast<float>(circle.x_px);
  const auto cy = static_cast<float>(circle.y_px);
  const float reach_px = radius + 6.5F * width_px + trail_px;
  const int stride = static_cast<int>(std::ceil(reach_px / static_cast<float>(most_half_width)));
  const auto first = [&](float centre) {
    return static_cast<int>(std::lround(centre)) - static_cast<int>(reach_px) / stride * stride;
  };
  const auto begin = [&](float centre) {
    const int from = first(centre);
    return from >= 0 ? from : from + (-from + stride - 1) / stride * stride;
  };
  const int x_end = std::min(size.width - 1, static_cast<int>(cx + reach_px));
  const int y_end = std::min(size.height - 1, static_cast<int>(cy + reach_px));
  const std::int64_t disc_horizon_us = horizon_us(disc_px_s);
  const std::int64_t background_horizon_us = horizon_us(background_px_s);
  const std::int64_t longest_us = std::max(disc_horizon_us, background_horizon_us);
  const auto disc_motion = static_cast<float>(std::max(disc_px_s, slowest_px_s) * 1e-6);
  const auto background_motion = static_cast<float>(std::max(background_px_s, slowest_px_s) * 1e-6);
  const Eigen::Vector2f disc = (motion.disc_px_s * 1e-6).cast<float>();
  const Eigen::Vector2f background = (motion.background_px_s * 1e-6).cast<float>();
  const auto growth = static_cast<float>(motion.growth_px_s * 1e-6);
  const auto pixels = static_cast<std::size_t>(size.pixels());

  Splat splat(width_px);
  for (int y = begin(cy); y <= y_end; y += stride) {
    for (int x = begin(cx); x <= x_end; x += stride) {
      const auto at = static_cast<std::size_t>(y * size.width + x);
      for (std::size_t p = 0; p < 2; ++p) {
        const std::int64_t t_us = newest_us[p * pixels + at];
        if (t_us == std::numeric_limits<std::int64_t>::min()) continue;
        const std::int64_t age_us = saturated_difference(now_us, t_us);
        if (age_us > longest_us) continue;
        const auto age = static_cast<float>(std::max<std::int64_t>(age_us, 0));
        const float from_x = static_cast<float>(x) - cx;
        const float from_y = static_cast<float>(y) - cy;
        if (age_us <= disc_horizon_us) {
          const float dx = from_x + disc.x() * age;
          const float dy = from_y + disc.y() * age;
          splat.add(dx, dy, std::sqrt(dx * dx + dy * dy) - radius + growth * age,
                    std::min(age * disc_motion, most_px), 4 * p);
        }
        if (age_us <= background_horizon_us) {
          const float dx = from_x + background.x() * age;
          const float dy = from_y + background.y() * age;
          splat.add(dx, dy, std::sqrt(dx * dx + dy * dy) - radius, std::min(age * background_motion, most_px),
                    4 * p + 2);
        }
      }
    }
  }

  const auto speeds = static_cast<float>(disc_px_s + background_px_s + slowest_px_s);
  float all = 0.0F;
  for (std::size_t d = 0; d < PolarPatch::directions; ++d) {
    const float angle = 2.0F * pi * static_cast<float>(d) / PolarPatch::directions;
    const float c = std::cos(angle);
    const float s = std::sin(angle);
    for (std::size_t r = 0; r < PolarPatch::rings; ++r) {
      float* value = &patch.values[(d * PolarPatch::rings + r) * PolarPatch::channels];
      const float at_px = radius + (static_cast<float>(r) - outline_ring) * width_px;
      const float area_px2 = width_px * 2.0F * pi / PolarPatch::directions * std::max(at_px, 0.5F * width_px);
      const float per_px2 = static_cast<float>(stride * stride) / area_px2;
      for (std::size_t k = 0; k < PolarPatch::event_channels; ++k) {
        value[k] = splat.of(d, r)[k] * per_px2;
        all += value[k];
      }
      const float x = cx + at_px * c;
      const float y = cy + at_px * s;
      const bool inside = x > -0.5F && y > -0.5F && x < static_cast<float>(size.width) - 0.5F &&
                          y < static_cast<float>(size.height) - 0.5F;
      value[8] = inside ? 1.0F : 0.0F;
      value[9] = static_cast<float>(motion.disc_px_s.x() * static_cast<double>(c) +
                                    motion.disc_px_s.y() * static_cast<double>(s)) /
                 speeds;
      value[10] = static_cast<float>(motion.background_px_s.x() * static_cast<double>(c) +
                                     motion.background_px_s.y() * static_cast<double>(s)) /
                  speeds;
    }
  }
  patch.about = {std::log(radius),
                 log_speed(disc_px_s),
                 log_speed(background_px_s),
                 log_speed((motion.disc_px_s - motion.background_px_s).norm()),
                 log_speed(std::abs(motion.growth_px_s)),
                 all / static_cast<float>(patch.values.size())};
  return patch;
}

}  // namespace saccade::inline v0_1
