#include "core/tracker/polar_patch.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/time_stamp.h"
#include "core/vector_clones.h"

namespace saccade {
namespace {

constexpr float pi = std::numbers::pi_v<float>;
constexpr double slowest_px_s = 4.0;  // motion that an event's weight falls by at least
constexpr float most_px = 16.0F;      // of motion since an event
constexpr float trail_px = 4.0F;      // read beyond the outermost ring
constexpr int most_half_width = 30;   // pixels read from the centre in each direction
constexpr float outline_ring = 7.0F;  // index of the ring on the outline

using Pair [[gnu::vector_size(8), gnu::may_alias]] = float;  // weights of 2 and of 8 px

/// exp(-m / 2 px) and exp(-m / 8 px) by steps of 1/8 px.
struct Weights {
  static constexpr std::size_t steps = 129;
  Pair of[steps];
};
const Weights& weights() {
  static const Weights table = [] {
    Weights w{};
    for (std::size_t i = 0; i < Weights::steps; ++i) {
      const double m = static_cast<double>(i) / 8.0;
      w.of[i] = Pair{static_cast<float>(std::exp(-m / 2.0)), static_cast<float>(std::exp(-m / 8.0))};
    }
    return w;
  }();
  return table;
}

/// Unit vectors of the directions.
using Directions = std::array<std::array<float, 2>, PolarPatch::directions>;
const Directions& unit_vectors() {
  static const Directions table = [] {
    Directions of;
    for (std::size_t d = 0; d < PolarPatch::directions; ++d) {
      const float angle = 2.0F * pi * static_cast<float>(d) / PolarPatch::directions;
      of[d] = {std::cos(angle), std::sin(angle)};
    }
    return of;
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

/// Events near the circle, some at a time: place from its centre (px), age (us), 1 for an OFF event.
struct Batch {
  static constexpr std::size_t most = 512, most_of_row = 2 * (2 * most_half_width + 1);
  alignas(32) std::array<float, most> x, y, age_us;
  std::array<std::uint8_t, most> off;
  std::size_t count = 0;
};

/// One of the two motions, in px per us, by which an event is carried on for at most horizon_us.
struct Carried {
  float x, y, growth, length;
  float horizon_us;
  std::size_t channel;  // of ON
};

constexpr int splat_rings = PolarPatch::rings + 2;  // with one more inside and outside

/// Where events of a batch come to lie: between two directions and two rings.
struct Places {
  /// Index of the inner ring's cell, in the first and in the second direction.
  alignas(32) std::array<std::int32_t, Batch::most> here, next;
  alignas(32) std::array<std::int32_t, Batch::most> weight;  ///< index into Weights
  alignas(32) std::array<std::int32_t, Batch::most> near;    ///< 1 within the rings and horizon, else 0
  /// Shares of the second direction and of the outer ring.
  alignas(32) std::array<float, Batch::most> direction_share, ring_share;
};

SACCADE_VECTOR_CLONES
void carry(const Batch& batch, const Carried& by, float radius_px, float per_width, Places& places) {
  constexpr auto count = static_cast<std::int32_t>(PolarPatch::directions);
  for (std::size_t i = 0; i < batch.count; ++i) {
    const float age = batch.age_us[i];
    const float x = batch.x[i] + by.x * age;
    const float y = batch.y[i] + by.y * age;
    const float off_px = std::sqrt(x * x + y * y) - radius_px + by.growth * age;
    const float ring = off_px * per_width + (outline_ring + 1.0F);
    const bool near = (age <= by.horizon_us) & (ring > 0.0F) & (ring < static_cast<float>(splat_rings - 1));
    const float direction = turns(x, y) * static_cast<float>(count);
    const auto d = static_cast<std::int32_t>(direction);
    const auto r = static_cast<std::int32_t>(near ? ring : 0.0F);
    const std::int32_t this_one = d < count ? d : 0;
    places.near[i] = near ? 1 : 0;
    places.here[i] = this_one * splat_rings + r;
    places.next[i] = (this_one + 1 < count ? this_one + 1 : 0) * splat_rings + r;
    places.direction_share[i] = direction - static_cast<float>(d);
    places.ring_share[i] = ring - static_cast<float>(r);
    places.weight[i] = static_cast<std::int32_t>(std::min(age * by.length, most_px) * 8.0F);
  }
}

/// Sums of weights by direction, ring and event channel.
class Splat {
 public:
  void add(const Batch& batch, const Places& places, std::size_t channel_of_on) {
    // Collects those within the rings first, without branches: which ones these are is hard to predict.
    std::array<std::uint16_t, Batch::most> near;
    std::size_t count = 0;
    for (std::size_t i = 0; i < batch.count; ++i) {
      near[count] = static_cast<std::uint16_t>(i);
      count += static_cast<std::size_t>(places.near[i]);
    }
    for (std::size_t k = 0; k < count; ++k) {
      const std::size_t i = near[k];
      const Pair& w = weights().of[static_cast<std::size_t>(places.weight[i])];
      const std::size_t channel = channel_of_on + 4 * batch.off[i];
      add_pair(at(places.here[i]) + channel, 1.0F - places.direction_share[i], places.ring_share[i], w);
      add_pair(at(places.next[i]) + channel, places.direction_share[i], places.ring_share[i], w);
    }
  }
  [[nodiscard]] const float* of(std::size_t direction, std::size_t ring) const {
    return sums_.data() + (direction * splat_rings + ring + 1) * channels;
  }

 private:
  static constexpr std::size_t channels = PolarPatch::event_channels;

  [[nodiscard]] float* at(std::int32_t place) {
    return sums_.data() + static_cast<std::size_t>(place) * channels;
  }
  static void add_pair(float* inner, float share, float outer_share, const Pair& w) {
    const float to_outer = share * outer_share;
    const float to_inner = share - to_outer;
    auto* sums = reinterpret_cast<Pair*>(inner);
    sums[0] += to_inner * w;
    sums[channels / 2] += to_outer * w;
  }

  alignas(Pair) std::array<float, PolarPatch::directions * splat_rings * channels> sums_{};
};

std::int64_t horizon_us(double speed_px_s) {
  return static_cast<std::int64_t>(static_cast<double>(most_px) / std::max(speed_px_s, slowest_px_s) * 1e6);
}

float log_speed(double px_s) { return static_cast<float>(std::log1p(px_s)); }

}  // namespace

PolarPatch polar_patch(const TimeSurface& surface, const Circle& circle, const PatchMotion& motion,
                       std::int64_t now_us) {
  PolarPatch patch;
  const ImageSize size = surface.size();
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
  // Of an event that counts; above TimeSurface::never_us.
  const std::int64_t earliest_us =
      std::max(saturated_difference(now_us, std::max(disc_horizon_us, background_horizon_us)),
               TimeSurface::never_us + 1);
  const auto carried = [&](const Eigen::Vector2d& px_s, double growth_px_s, std::int64_t horizon,
                           std::size_t channel) {
    const Eigen::Vector2f px_us = (px_s * 1e-6).cast<float>();
    return Carried{px_us.x(),
                   px_us.y(),
                   static_cast<float>(growth_px_s * 1e-6),
                   static_cast<float>(std::max(px_s.norm(), slowest_px_s) * 1e-6),
                   static_cast<float>(horizon),
                   channel};
  };
  const std::array<Carried, 2> motions = {carried(motion.disc_px_s, motion.growth_px_s, disc_horizon_us, 0),
                                          carried(motion.background_px_s, 0.0, background_horizon_us, 2)};
  const std::array<const std::int64_t*, 2> newest_us = {surface.newest_us(true).data(),
                                                        surface.newest_us(false).data()};

  Splat splat;
  Batch batch;
  const auto add_batch = [&] {
    Places places;
    for (const Carried& by : motions) {
      carry(batch, by, radius, 1.0F / width_px, places);
      splat.add(batch, places, by.channel);
    }
    batch.count = 0;
  };
  for (int y = begin(cy); y <= y_end; y += stride) {
    if (batch.count > Batch::most - Batch::most_of_row) add_batch();
    for (int x = begin(cx); x <= x_end; x += stride) {
      const auto at = static_cast<std::size_t>(y * size.width + x);
      for (std::size_t p = 0; p < 2; ++p) {
        const std::int64_t t_us = newest_us[p][at];
        batch.x[batch.count] = static_cast<float>(x) - cx;
        batch.y[batch.count] = static_cast<float>(y) - cy;
        batch.age_us[batch.count] =
            static_cast<float>(std::max<std::int64_t>(saturated_difference(now_us, t_us), 0));
        batch.off[batch.count] = static_cast<std::uint8_t>(p);
        batch.count += static_cast<std::size_t>(t_us >= earliest_us);
      }
    }
  }
  add_batch();

  const auto speeds = static_cast<float>(disc_px_s + background_px_s + slowest_px_s);
  std::array<float, PolarPatch::rings> at_px, per_px2;
  for (std::size_t r = 0; r < PolarPatch::rings; ++r) {
    at_px[r] = radius + (static_cast<float>(r) - outline_ring) * width_px;
    const float area_px2 =
        width_px * 2.0F * pi / PolarPatch::directions * std::max(at_px[r], 0.5F * width_px);
    per_px2[r] = static_cast<float>(stride * stride) / area_px2;
  }
  float all = 0.0F;
  for (std::size_t d = 0; d < PolarPatch::directions; ++d) {
    const float c = unit_vectors()[d][0];
    const float s = unit_vectors()[d][1];
    const auto along_normal = [&](const Eigen::Vector2d& px_s) {
      return static_cast<float>(px_s.x() * static_cast<double>(c) + px_s.y() * static_cast<double>(s)) /
             speeds;
    };
    const float disc_share = along_normal(motion.disc_px_s);
    const float background_share = along_normal(motion.background_px_s);
    for (std::size_t r = 0; r < PolarPatch::rings; ++r) {
      float* value = &patch.values[(d * PolarPatch::rings + r) * PolarPatch::channels];
      for (std::size_t k = 0; k < PolarPatch::event_channels; ++k) {
        value[k] = splat.of(d, r)[k] * per_px2[r];
        all += value[k];
      }
      const float x = cx + at_px[r] * c;
      const float y = cy + at_px[r] * s;
      const bool inside = x > -0.5F && y > -0.5F && x < static_cast<float>(size.width) - 0.5F &&
                          y < static_cast<float>(size.height) - 0.5F;
      value[8] = inside ? 1.0F : 0.0F;
      value[9] = disc_share;
      value[10] = background_share;
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

}  // namespace saccade
