#include "core/baselines/kernel_search.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.h"

namespace saccade {
namespace {

// The ratio of PUCK's kernel; their sum is 1, so that an even texture has no response.
constexpr double inside_weight = 0.75, outside_weight = 0.25;
constexpr double inner_gap_px = 2.5, outer_gap_px = 3.5;  // between the outline and the areas beside it
constexpr double outer_share = 1.2;                       // of the radius: how far out the kernel reaches
constexpr int reach_px = 3;                               // of the disc that is followed, in a step; chosen
constexpr int grid_px = 3;             // between places of the search of the whole image; chosen
constexpr std::size_t grid_radii = 2;  // between the radii of its kernels; chosen
constexpr std::int64_t kernels_per_step =
    1500;  // of the search of the whole image: bounds the work of a step
constexpr int pixels_per_step =
    8192;                       // smoothed for the search of the whole image: bounds the work of a step
constexpr int refinements = 3;  // of the best match on the grid; chosen

}  // namespace

KernelSearch::KernelSearch(const std::array<double, 2>& radius_px, ImageSize size)
    : size_(size),
      margin_(static_cast<int>(std::max(outer_share * radius_px[1], radius_px[1] + outer_gap_px)) + 4),
      stride_(size.width + 2 * margin_),
      columns_((size.width + grid_px - 1) / grid_px),
      rows_((size.height + grid_px - 1) / grid_px) {
  for (int r = static_cast<int>(radius_px[0]); r <= static_cast<int>(radius_px[1]); ++r) {
    kernels_.push_back(kernel(r));
  }
  const auto pixels = static_cast<std::size_t>(stride_) * static_cast<std::size_t>(size.height + 2 * margin_);
  level_.resize(pixels, 0);
  row_sum_.resize(pixels, 0);
  smooth_.resize(pixels, 0);
  const auto radii = static_cast<std::int64_t>((kernels_.size() + grid_radii - 1) / grid_radii);
  const std::int64_t places_per_step = std::max<std::int64_t>(1, kernels_per_step / radii);
  const std::int64_t places = static_cast<std::int64_t>(columns_) * rows_;
  sweep_steps_ = (places + places_per_step - 1) / places_per_step;
}

/// Pixels at even angles on the outline and outside it, and on a spiral inside it.
KernelSearch::Kernel KernelSearch::kernel(int r_px) const {
  Kernel k;
  k.r_px = r_px;
  k.gain = std::sqrt(r_px);
  const auto offset = [this](double distance_px, double angle_rad) {
    return static_cast<std::int32_t>(std::lround(distance_px * std::sin(angle_rad)) * stride_ +
                                     std::lround(distance_px * std::cos(angle_rad)));
  };
  const double turn = 2.0 * std::numbers::pi;
  for (int i = 0; i < outline_pixels; ++i) {
    k.outline[static_cast<std::size_t>(i)] = offset(r_px, turn * i / outline_pixels);
  }
  const double inside_px = std::max(0.5 * r_px, r_px - inner_gap_px);
  for (int i = 0; i < inside_pixels; ++i) {
    const double golden_angle = turn * (2.0 - std::numbers::phi);
    k.inside[static_cast<std::size_t>(i)] =
        offset(inside_px * std::sqrt((i + 0.5) / inside_pixels), golden_angle * i);
  }
  const double outside_px = std::max(outer_share * r_px, r_px + outer_gap_px);
  for (int i = 0; i < outside_pixels; ++i) {
    k.outside[static_cast<std::size_t>(i)] = offset(outside_px, turn * i / outside_pixels);
  }
  return k;
}

/// Takes a part of the surface into the smoothed image.
void KernelSearch::smooth(std::span<const double> surface, int x_begin, int x_end, int y_begin, int y_end) {
  x_begin = std::max(x_begin, 0);
  x_end = std::min(x_end, size_.width);
  y_begin = std::max(y_begin, 0);
  y_end = std::min(y_end, size_.height);
  if (x_begin >= x_end || y_begin >= y_end) return;
  const int from = std::max(x_begin - 2, 0);
  const int to = std::min(x_end + 2, size_.width);
  for (int y = std::max(y_begin - 2, 0); y < std::min(y_end + 2, size_.height); ++y) {
    const double* const value = surface.data() + static_cast<std::ptrdiff_t>(y) * size_.width;
    std::uint16_t* const level = level_.data() + at(0, y);
    for (int x = from; x < to; ++x) {
      level[x] = static_cast<std::uint16_t>(static_cast<int>(std::min(value[x], 255.0) + 0.5));
    }
    std::uint16_t* const sum = row_sum_.data() + at(0, y);
    for (int x = x_begin; x < x_end; ++x) {
      sum[x] = static_cast<std::uint16_t>(level[x - 2] + level[x + 2] + 4 * (level[x - 1] + level[x + 1]) +
                                          6 * level[x]);
    }
  }
  for (int y = y_begin; y < y_end; ++y) {
    const std::uint16_t* const sum = row_sum_.data() + at(0, y);
    std::uint8_t* const smooth = smooth_.data() + at(0, y);
    for (int x = x_begin; x < x_end; ++x) {
      const int total = sum[x - 2 * stride_] + sum[x + 2 * stride_] +
                        4 * (sum[x - stride_] + sum[x + stride_]) + 6 * sum[x];
      smooth[x] = static_cast<std::uint8_t>((total + 128) / 256);
    }
  }
}

/// Takes the kernel for the best if it is stronger.
void KernelSearch::consider(Match& best, int x, int y, std::size_t radius) const {
  const Kernel& k = kernels_[radius];
  const std::uint8_t* const centre = smooth_.data() + at(x, y);
  const auto mean = [centre](const auto& offsets) {
    int sum = 0;
    for (const std::int32_t offset : offsets) sum += centre[offset];
    return static_cast<double>(sum) / (255.0 * static_cast<double>(offsets.size()));
  };
  double response = mean(k.outline);
  if (k.gain * response <= best.strength) return;  // what lies beside the outline only lowers it
  response -= inside_weight * mean(k.inside) + outside_weight * mean(k.outside);
  if (k.gain * response > best.strength) best = {x, y, radius, response, k.gain * response};
}

KernelSearch::Match KernelSearch::largest_near(const Match& start) const {
  Match best;
  consider(best, start.x, start.y, start.radius);  // of equal strengths the one of no motion
  const std::size_t first = start.radius == 0 ? 0 : start.radius - 1;
  const std::size_t last = std::min(start.radius + 1, kernels_.size() - 1);
  for (std::size_t radius = first; radius <= last; ++radius) {
    for (int y = std::max(0, start.y - reach_px); y <= std::min(size_.height - 1, start.y + reach_px); ++y) {
      for (int x = std::max(0, start.x - reach_px); x <= std::min(size_.width - 1, start.x + reach_px); ++x) {
        consider(best, x, y, radius);
      }
    }
  }
  return best;
}

void KernelSearch::follow(std::span<const double> surface) {
  if (!found_) return;
  const int half = margin_ + reach_px;
  smooth(surface, disc_.x - half, disc_.x + half + 1, disc_.y - half, disc_.y + half + 1);
  disc_ = largest_near(disc_);
}

int KernelSearch::rows_to_smooth() const { return std::max(1, pixels_per_step / size_.width); }

void KernelSearch::sweep(std::span<const double> surface) {
  const int rows = rows_to_smooth();
  smooth(surface, 0, size_.width, smoothed_row_, smoothed_row_ + rows);
  smoothed_row_ = smoothed_row_ + rows < size_.height ? smoothed_row_ + rows : 0;

  const std::int64_t places = static_cast<std::int64_t>(columns_) * rows_;
  const std::int64_t end = std::min(places, place_ + (places + sweep_steps_ - 1) / sweep_steps_);
  for (; place_ < end; ++place_) {
    const int x = std::min(size_.width - 1, static_cast<int>(place_ % columns_) * grid_px + grid_px / 2);
    const int y = std::min(size_.height - 1, static_cast<int>(place_ / columns_) * grid_px + grid_px / 2);
    for (std::size_t radius = 0; radius < kernels_.size(); radius += grid_radii) {
      consider(sweep_best_, x, y, radius);
    }
  }
  if (place_ < places) return;
  for (int i = 0; i < refinements; ++i) sweep_best_ = largest_near(sweep_best_);
  if (!found_ || sweep_best_.strength > disc_.strength) disc_ = sweep_best_;
  found_ = true;
  sweep_best_ = {};
  place_ = 0;
}

std::int64_t KernelSearch::steps_to_settle() const {
  const std::int64_t smoothing_steps = size_.height / rows_to_smooth() + 1;
  return 2 * std::max(sweep_steps_, smoothing_steps);
}

void KernelSearch::step(std::span<const double> surface) {
  SACCADE_CHECK(std::ssize(surface) == size_.pixels());
  follow(surface);
  sweep(surface);
}

Estimate KernelSearch::disc() const {
  if (!found_ || disc_.response <= 0.0) return {};
  const Circle circle{static_cast<double>(disc_.x), static_cast<double>(disc_.y),
                      static_cast<double>(kernels_[disc_.radius].r_px)};
  return {true, false, circle, disc_.response};
}

}  // namespace saccade
