#include "core/baselines/multi_kernel.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace saccade {
namespace {

constexpr int steps_per_px = 8;  // of the table of the profile
constexpr double reach = 6.0;    // of the profile, in half-widths of the ring
constexpr double least_activity =
    0.5;  // of a tracker that follows something; below, it goes back to the grid; chosen
/// The radius at which a tracker aims to hold an event, as a share of its ring. Below 1, because a ring that is too
/// large would otherwise stay where it touches the circle from outside.
constexpr double aim = 0.9;

}  // namespace

void describe(FieldVisitor& v, MultiKernelConfig& config) {
  describe_radius_px(v, config.radius_px);
  v.real("radius_step_px", config.radius_step_px, {0.5, 20.0}, "step between the radii of kernels");
  v.real("ring_px", config.ring_px, {0.5, 10.0}, "half-width of a ring");
  v.real("spacing_px", config.spacing_px, {5.0, 1000.0}, "distance between the rest positions of trackers");
  v.real("pull", config.pull, {1e-3, 1.0}, "share of the distance to an event that its tracker moves");
  v.real("decay_us", config.decay_us, {100.0, 1e7}, "time constant of activity");
  v.real("threshold", config.threshold, {0.0, 1e6}, "least activity that is taken for the ball");
}

MultiKernelDetector::MultiKernelDetector(const MultiKernelConfig& config, ImageSize size)
    : config_(config), sieve_(size), last_us_(std::numeric_limits<std::int64_t>::min()), now_us_(last_us_) {
  check_config("detector", config);
  for (double r = config.radius_px[0]; r <= config.radius_px[1]; r += config.radius_step_px) {
    radii_px_.push_back(r);
    norm_.push_back(std::sqrt(2.0 * std::numbers::pi * r));
  }
  for (int i = 0; i <= static_cast<int>(reach * config.ring_px * steps_per_px); ++i) {
    const double off = static_cast<double>(i) / steps_per_px / config.ring_px;
    profile_.push_back(std::exp(-off * off / 2) - 0.5 * std::exp(-off * off / 8));
  }
  reach_px_ = radii_px_.back() + static_cast<double>(profile_.size()) / steps_per_px;
  const auto homes = [&](int length) { return std::max(1, static_cast<int>(length / config.spacing_px)); };
  const int columns = homes(size.width);
  const int rows = homes(size.height);
  for (int i = 0; i < columns * rows; ++i) {
    const int column = i % columns;
    const int row = i / columns;
    Tracker tracker;
    tracker.home_x_px = (column + 0.5) * size.width / columns - 0.5;
    tracker.home_y_px = (row + 0.5) * size.height / rows - 0.5;
    tracker.activity.resize(radii_px_.size(), 0.0);
    return_to_grid(tracker);
    trackers_.push_back(std::move(tracker));
  }
}

double MultiKernelDetector::kernel(double off_px) const {
  // Not negative: this rounds. NOLINTNEXTLINE(bugprone-incorrect-roundings)
  const auto step = static_cast<std::size_t>(std::abs(off_px) * steps_per_px + 0.5);
  return step < profile_.size() ? profile_[step] : 0.0;
}

void MultiKernelDetector::return_to_grid(Tracker& tracker) {
  tracker.x_px = tracker.home_x_px;
  tracker.y_px = tracker.home_y_px;
}

/// Fades the activities and adds the event's kernels.
void MultiKernelDetector::excite(Tracker& tracker, const Event& event, double fading) const {
  for (double& activity : tracker.activity) activity *= fading;
  const double dx = event.x - tracker.x_px;
  const double dy = event.y - tracker.y_px;
  if (std::abs(dx) < reach_px_ && std::abs(dy) < reach_px_) {
    const double distance_px = std::hypot(dx, dy);
    for (std::size_t k = 0; k < radii_px_.size(); ++k) {
      const double value = kernel(distance_px - radii_px_[k]);
      if (value != 0.0) tracker.activity[k] = std::max(0.0, tracker.activity[k] + value / norm_[k]);
    }
  }
  tracker.best = static_cast<std::size_t>(std::max_element(tracker.activity.begin(), tracker.activity.end()) -
                                          tracker.activity.begin());
}

/// Of an excited tracker to the event; at most its best activity.
double MultiKernelDetector::response(const Tracker& tracker, const Event& event) const {
  const double distance_px = std::hypot(event.x - tracker.x_px, event.y - tracker.y_px);
  const double off = (distance_px - radii_px_[tracker.best]) / config_.ring_px;
  return best_activity(tracker) * std::exp(-off * off / 8);
}

void MultiKernelDetector::move(Tracker& tracker, double response, const Event& event) {
  const double dx = event.x - tracker.x_px;
  const double dy = event.y - tracker.y_px;
  const double share = response / best_activity(tracker);
  const double nearer = 1.0 - aim * radii_px_[tracker.best] / std::max(1.0, std::hypot(dx, dy));
  tracker.x_px += config_.pull * share * nearer * dx;
  tracker.y_px += config_.pull * share * nearer * dy;
  for (Tracker& other : trackers_) {
    const double apart_px = std::hypot(other.x_px - tracker.x_px, other.y_px - tracker.y_px);
    if (&other == &tracker || apart_px >= radii_px_[tracker.best]) continue;
    Tracker& weaker = best_activity(other) < best_activity(tracker) ? other : tracker;
    std::fill(weaker.activity.begin(), weaker.activity.end(), 0.0);
    return_to_grid(weaker);
  }
}

void MultiKernelDetector::process(std::span<const Event> events, const CameraMotion*) {
  for (const Event& event : events) {
    if (!sieve_.accept(event)) continue;
    const double age_us = static_cast<double>(event.t_us) - static_cast<double>(last_us_);
    const double fading = std::exp(-age_us / config_.decay_us);
    last_us_ = event.t_us;
    now_us_ = std::max(now_us_, event.t_us);
    Tracker* winner = nullptr;
    double most = 0.0;
    for (Tracker& tracker : trackers_) {
      excite(tracker, event, fading);
      if (best_activity(tracker) > most) {
        if (const double value = response(tracker, event); value > most) {
          most = value;
          winner = &tracker;
        }
      }
      if (best_activity(tracker) < least_activity) return_to_grid(tracker);
    }
    if (winner != nullptr && best_activity(*winner) >= least_activity) move(*winner, most, event);
  }
}

void MultiKernelDetector::advance_to(std::int64_t now_us, const CameraMotion*) {
  now_us_ = std::max(now_us_, now_us);
}

Estimate MultiKernelDetector::estimate() {
  const Tracker& best =
      *std::max_element(trackers_.begin(), trackers_.end(),
                        [this](const auto& a, const auto& b) { return best_activity(a) < best_activity(b); });
  const double age_us = static_cast<double>(now_us_) - static_cast<double>(last_us_);
  const double score = best_activity(best) * std::exp(-age_us / config_.decay_us);
  if (score < least_activity) return {};
  return {true, false, {best.x_px, best.y_px, radii_px_[best.best]}, score};
}

}  // namespace saccade
