#include "core/tracker/silhouette.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/time_stamp.h"

namespace saccade {
namespace {

constexpr std::int64_t memory_us = 50'000;
constexpr int sectors = 24;
constexpr double sector_rad = 2.0 * std::numbers::pi / sectors;
constexpr double bin_px = 0.5;
constexpr int inner_bins = 8, outer_bins = 8;  // on both sides of the circle
constexpr int bins = inner_bins + outer_bins;
constexpr double inside_px = 1.25, near_px = 0.75, far_px = 4.0;
constexpr int fewest_outside = 20;
constexpr double telling_ratio = 2.5;  // density outside over inside, for a sector to tell
constexpr double least_seen = 0.3;
/// A pixel that the outline crosses sees a part of what moves behind it: events begin inside of the outline.
constexpr double outline_at_px = 0.35;
constexpr double largest_step_px = 2.0, finest_step_px = 0.125;

/// Log likelihood of an outline at every distance from the circle, sector by sector.
struct Likelihood {
  std::array<std::array<double, bins + 1>, sectors> at{};
  std::array<Eigen::Vector3d, sectors> slope{};  ///< distance in the sector by x, y and r

  double operator()(const Eigen::Vector3d& step) const {
    double sum = 0.0;
    for (std::size_t k = 0; k < sectors; ++k) {
      const double bin = std::clamp(slope[k].dot(step) / bin_px + inner_bins, 0.0, bins - 1e-9);
      const auto low = static_cast<std::size_t>(bin);
      const double share = bin - static_cast<double>(low);
      sum += (1.0 - share) * at[k][low] + share * at[k][low + 1];
    }
    return sum;
  }
};

}  // namespace

std::optional<Silhouette::Fit> Silhouette::fit(const Circle& c, const Eigen::Vector2d& carried_px,
                                               std::int64_t now_us) const {
  const Eigen::Vector2d centre = Eigen::Vector2d(c.x_px, c.y_px) - carried_px;
  std::array<std::array<int, bins>, sectors> counts{};
  std::array<int, sectors> outside{};
  int inside = 0, all_outside = 0, just_outside = 0;
  for (std::size_t i = 0; i < std::min(count_, near_.size()); ++i) {
    const Near& event = near_[(count_ - 1 - i) % near_.size()];
    if (saturated_difference(now_us, event.t_us) > memory_us) break;
    const Eigen::Vector2d offset = event.at_px - centre;
    const double off_px = offset.norm() - c.r_px + outline_at_px;
    if (off_px >= far_px) continue;
    const double turn = (std::atan2(offset.y(), offset.x()) + std::numbers::pi) / sector_rad;
    const auto sector = std::min(static_cast<std::size_t>(turn), static_cast<std::size_t>(sectors - 1));
    const int bin = static_cast<int>(std::floor(off_px / bin_px)) + inner_bins;
    if (off_px < -inside_px) ++inside;
    if (bin >= 0 && bin < bins) ++counts[sector][static_cast<std::size_t>(bin)];
    if (off_px > near_px) {
      ++outside[sector];
      ++all_outside;
    }
    if (std::abs(off_px) <= near_px) ++just_outside;
  }
  if (all_outside < fewest_outside) return std::nullopt;

  const auto disc = [&](double off_px) {
    const double r = std::max(0.0, c.r_px - outline_at_px + off_px);
    return std::numbers::pi * r * r;
  };
  const double inside_per_px2 = (inside + 0.5) / std::max(disc(-inside_px), 1.0);
  const double ring_px2 = (disc(far_px) - disc(near_px)) / sectors;
  Likelihood likelihood;
  int telling = 0;
  for (std::size_t k = 0; k < sectors; ++k) {
    const double angle = (static_cast<double>(k) + 0.5) * sector_rad - std::numbers::pi;
    likelihood.slope[k] = {std::cos(angle), std::sin(angle), 1.0};
    const int around = outside[(k + sectors - 1) % sectors] + outside[k] + outside[(k + 1) % sectors];
    const double outside_per_px2 = around / (3.0 * ring_px2);
    if (outside_per_px2 < telling_ratio * inside_per_px2) continue;
    ++telling;
    const double cost = std::log(inside_per_px2 / outside_per_px2);
    double sum = 0.0;
    for (std::size_t b = 0; b < bins; ++b) {
      const double from = (static_cast<double>(b) - inner_bins) * bin_px;
      sum += counts[k][b] * cost +
             (outside_per_px2 - inside_per_px2) * (disc(from + bin_px) - disc(from)) / sectors;
      likelihood.at[k][b + 1] = sum;
    }
  }
  Fit fit;
  fit.seen = static_cast<double>(telling) / sectors;
  if (fit.seen < least_seen) return std::nullopt;

  Eigen::Vector3d best = Eigen::Vector3d::Zero();
  double most = likelihood(best);
  for (double step = 0.5; step >= finest_step_px; step *= 0.5) {
    for (bool better = true; better;) {
      better = false;
      for (int axis = 0; axis < 3; ++axis) {
        for (const double sign : {-1.0, 1.0}) {
          const Eigen::Vector3d to = best + sign * step * Eigen::Vector3d::Unit(axis);
          if (to.cwiseAbs().maxCoeff() > largest_step_px) continue;
          const double value = likelihood(to);
          if (value <= most + 1e-9) continue;
          most = value;
          best = to;
          better = true;
        }
      }
    }
  }
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d aside = 0.5 * Eigen::Vector3d::Unit(axis);
    const double curvature = (2.0 * most - likelihood(best + aside) - likelihood(best - aside)) / 0.25;
    fit.sd_px[axis] = 1.0 / std::sqrt(std::max(curvature, 0.05));
  }
  fit.circle = {c.x_px + best.x(), c.y_px + best.y(), c.r_px + best.z()};
  const double outside_per_px2 = all_outside / (ring_px2 * sectors);
  fit.emptiness = std::clamp(1.0 - inside_per_px2 / outside_per_px2, 0.0, 1.0);
  fit.tightness = std::min(1.0, just_outside / (disc(near_px) - disc(-near_px)) / outside_per_px2);
  return fit;
}

}  // namespace saccade
