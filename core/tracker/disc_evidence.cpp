#include "core/tracker/disc_evidence.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>

#include "core/flow/plane_fit_flow.h"

namespace saccade {
namespace {

constexpr double pi = std::numbers::pi;
// Geometry of the evidence, px: the rasterised outline is 2.5 px wide, clutter is counted in two sides of 3 px.
constexpr double ring_half_px = 1.25, side_begin_px = 2.0, side_end_px = 5.0, spread_reach_px = 2.5;
constexpr double sector_px = 2.5;
constexpr int min_sectors = 8, max_sectors = 32;
constexpr double radial_cosine = 0.866;  // 30 deg, the error of a plane-fit flow
constexpr double visible_share =
    0.4;  // of the speed, along the normal: from here on a sector must show edges
constexpr double visible_px_s = 8.0;
constexpr double consistent = 0.1;          // likelihood from which on an edge may move as the disc
constexpr double least_px2 = 3.0;           // of an area that is divided by
constexpr double clutter_scale_px2 = 20.0;  // log(1 + scale * density)
constexpr double ring_floor = 0.01;         // edges per px^2 that count as none

/// Unit vectors to the middles of n sectors, counted from -x on.
using Sectors = std::array<std::array<double, 2>, max_sectors>;
const Sectors& sector_middles(int n) {
  static const auto table = [] {
    std::array<Sectors, max_sectors + 1> of{};
    for (int sectors = min_sectors; sectors <= max_sectors; ++sectors) {
      for (int k = 0; k < sectors; ++k) {
        const double angle = (k + 0.5) / sectors * 2.0 * pi - pi;
        of[static_cast<std::size_t>(sectors)][static_cast<std::size_t>(k)] = {std::cos(angle),
                                                                              std::sin(angle)};
      }
    }
    return of;
  }();
  return table[static_cast<std::size_t>(n)];
}

double ring_area_px2(double r_px, double from_px, double to_px) {
  const double inner = std::max(0.0, r_px + from_px);
  const double outer = std::max(0.0, r_px + to_px);
  return pi * (outer * outer - inner * inner);
}

double likelihood(double speed_px_s, double expected_px_s) {
  const double z = (speed_px_s - expected_px_s) / flow_sd_px_s(speed_px_s);
  return std::exp(-0.5 * z * z);
}

double log_density(double count, double area_px2) {
  return std::log(1.0 + clutter_scale_px2 * count / area_px2);
}

}  // namespace

double density_of(double log_density) { return std::expm1(log_density) / clutter_scale_px2; }

DiscEvidenceCollector::DiscEvidenceCollector(const Circle& circle, const Eigen::Vector3d& motion_px_s,
                                             const Eigen::Vector2d& background_px_s)
    : circle_(circle),
      velocity_px_s_(motion_px_s.head<2>()),
      background_px_s_(background_px_s),
      growth_px_s_(motion_px_s.z()),
      sectors_(std::clamp(static_cast<int>(std::lround(2.0 * pi * circle.r_px / sector_px)), min_sectors,
                          max_sectors)) {
  const double least =
      std::max(visible_px_s, visible_share * (velocity_px_s_.norm() + std::abs(growth_px_s_)));
  const Sectors& middles = sector_middles(sectors_);
  for (int k = 0; k < sectors_; ++k) {
    const auto& [x, y] = middles[static_cast<std::size_t>(k)];
    const double normal_px_s = velocity_px_s_.x() * x + velocity_px_s_.y() * y + growth_px_s_;
    if (std::abs(normal_px_s) > least) expected_ |= 1U << static_cast<unsigned>(k);
  }
}

void DiscEvidenceCollector::add(const Eigen::Vector2d& offset_px, const Eigen::Vector2d& along,
                                double speed_px_s) {
  const double distance = offset_px.norm();
  const double off = distance - circle_.r_px;
  if (off > side_end_px) return;
  const double cosine = distance > 0.5 ? along.dot(offset_px) / distance : 0.0;
  const bool radial = std::abs(cosine) > radial_cosine;
  if (off > side_begin_px) {
    side_outer_ += 1.0;
    if (radial) side_outer_radial_ += 1.0;
  }
  const auto as_disc = [&] {
    return likelihood(speed_px_s, velocity_px_s_.dot(along) + growth_px_s_ * cosine);
  };
  if (off < -side_begin_px) {
    if (radial && off > -side_end_px) side_inner_radial_ += 1.0;
    inside_ += 1.0;
    const double as_background = likelihood(speed_px_s, background_px_s_.dot(along));
    const double as_disc_too = as_disc();
    if (as_background > as_disc_too) inside_background_ += as_background * (1.0 - as_disc_too);
  }
  if (radial && std::abs(off) < spread_reach_px) {
    near_off2_px2_ += off * off;
    near_count_ += 1.0;
  }
  if (std::abs(off) > ring_half_px) return;
  ring_ += 1.0;
  if (!radial) return;
  ring_radial_ += 1.0;
  const double consistency = as_disc();
  ring_consistent_ += consistency;
  const double turn = (std::atan2(offset_px.y(), offset_px.x()) + pi) / (2.0 * pi);
  const std::uint32_t sector =
      1U << static_cast<unsigned>(std::min(static_cast<int>(turn * sectors_), sectors_ - 1));
  seen_ |= sector;
  if (consistency > consistent) seen_consistent_ |= sector;
}

DiscEvidence DiscEvidenceCollector::evidence() const {
  const double r_px = circle_.r_px;
  int gap = 0, run = 0;
  for (int i = 0; i < 2 * sectors_; ++i) {
    run = (seen_ >> static_cast<unsigned>(i % sectors_) & 1U) != 0 ? 0 : run + 1;
    gap = std::max(gap, std::min(run, sectors_));
  }
  const double ring = ring_radial_ / ring_area_px2(r_px, -ring_half_px, ring_half_px);
  const double inner_side_px2 = ring_area_px2(r_px, -side_end_px, -side_begin_px);
  const double outer_side_px2 = ring_area_px2(r_px, side_begin_px, side_end_px);
  const double sides = (side_inner_radial_ + side_outer_radial_) / (inner_side_px2 + outer_side_px2);
  const double inside_px2 = std::max(ring_area_px2(r_px, -r_px, -side_begin_px), least_px2);
  const double half_edge = 0.5 / inside_px2;
  const double sectors = sectors_;
  const int expected = std::popcount(expected_);

  DiscEvidence e;
  e[Evidence::closure] = std::popcount(seen_) / sectors;
  e[Evidence::expected_closure] =
      expected == 0 ? 0.0 : std::popcount(seen_consistent_ & expected_) / static_cast<double>(expected);
  e[Evidence::gap] = gap / sectors;
  e[Evidence::radial_share] = ring_radial_ / (ring_ + 1.0);
  e[Evidence::consistent_share] = ring_consistent_ / (ring_radial_ + 1.0);
  e[Evidence::ring_to_sides] = std::log((ring + ring_floor) / (sides + ring_floor));
  e[Evidence::spread_px2] = near_count_ > 3.0 ? near_off2_px2_ / near_count_ : 1.5;
  e[Evidence::background_inside] = log_density(inside_background_, inside_px2);
  e[Evidence::inside] = log_density(inside_, inside_px2);
  e[Evidence::outside] = log_density(side_outer_, outer_side_px2);
  e[Evidence::inside_to_outside] =
      std::log((inside_ / inside_px2 + half_edge) / (side_outer_ / outer_side_px2 + half_edge));
  e[Evidence::ring_per_length] = std::log(1.0 + 4.0 * ring_radial_ / (2.0 * pi * r_px));
  e[Evidence::radius] = std::log(r_px);
  e[Evidence::expected] = expected / sectors;
  e[Evidence::closure_squared] = e[Evidence::closure] * e[Evidence::closure];
  e[Evidence::closure_by_contrast] = e[Evidence::closure] * std::min(1.0, ring / (ring + sides + 1e-3));
  e[Evidence::radial_outside] = log_density(side_outer_radial_, outer_side_px2);
  e[Evidence::radial_inside] = log_density(side_inner_radial_, std::max(inner_side_px2, least_px2));
  return e;
}

}  // namespace saccade
