#include "core/baselines/multi_kernel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "core/vector_clones.h"

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

namespace multi_kernel {

/// One tracker's kernels and the values of each, in steps of 1 / steps_per_px from its ring.
struct Kernels {
  std::span<double> activity;
  const double* radius_px;
  const double* values;
  std::size_t values_per_kernel;
};

SACCADE_VECTOR_CLONES
void fade(std::span<double> activity, double by) {
  for (double& one : activity) one *= by;
}

/// Adds the values of kernels `first` to `last` for an event at a distance from the tracker. Returns the largest activity of all.
SACCADE_VECTOR_CLONES
double add_values(const Kernels& to, std::size_t first, std::size_t last, double distance_px) {
  for (std::size_t k = first; k < last; ++k) {
    // Not negative: this rounds. NOLINTNEXTLINE(bugprone-incorrect-roundings)
    const auto step = static_cast<std::size_t>(std::abs(distance_px - to.radius_px[k]) * steps_per_px + 0.5);
    if (step < to.values_per_kernel)
      to.activity[k] = std::max(0.0, to.activity[k] + to.values[k * to.values_per_kernel + step]);
  }
  constexpr std::size_t lanes = 4;
  std::array<double, lanes> most{};
  std::size_t k = 0;
  for (; k + lanes <= to.activity.size(); k += lanes)
    for (std::size_t i = 0; i < lanes; ++i) most[i] = std::max(most[i], to.activity[k + i]);
  for (; k < to.activity.size(); ++k) most[0] = std::max(most[0], to.activity[k]);
  return std::max(std::max(most[0], most[1]), std::max(most[2], most[3]));
}

}  // namespace multi_kernel

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
  std::vector<double> profile;
  for (int i = 0; i <= static_cast<int>(reach * config.ring_px * steps_per_px); ++i) {
    const double off = static_cast<double>(i) / steps_per_px / config.ring_px;
    profile.push_back(std::exp(-off * off / 2) - 0.5 * std::exp(-off * off / 8));
  }
  values_per_kernel_ = profile.size();
  kernels_per_px_ = 1.0 / config.radius_step_px;
  reach_px_ = static_cast<double>(values_per_kernel_) / steps_per_px;
  for (double r = config.radius_px[0]; r <= config.radius_px[1]; r += config.radius_step_px) {
    radii_px_.push_back(r);
    for (const double value : profile) values_.push_back(value / std::sqrt(2.0 * std::numbers::pi * r));
  }
  const auto homes = [&](int length) { return std::max(1, static_cast<int>(length / config.spacing_px)); };
  const int columns = homes(size.width);
  const int rows = homes(size.height);
  for (int i = 0; i < columns * rows; ++i) {
    const int column = i % columns;
    const int row = i / columns;
    Tracker tracker;
    tracker.home_x_px = (column + 0.5) * size.width / columns - 0.5;
    tracker.home_y_px = (row + 0.5) * size.height / rows - 0.5;
    return_to_grid(tracker);
    trackers_.push_back(tracker);
  }
  activity_.resize(trackers_.size() * radii_px_.size(), 0.0);
}

/// Of the most active kernel.
double MultiKernelDetector::best_radius_px(std::size_t tracker) {
  const std::span<double> all = activity(tracker);
  return radii_px_[static_cast<std::size_t>(std::max_element(all.begin(), all.end()) - all.begin())];
}

void MultiKernelDetector::return_to_grid(Tracker& tracker) {
  tracker.x_px = tracker.home_x_px;
  tracker.y_px = tracker.home_y_px;
}

/// Adds the event's kernels to activities that have faded.
void MultiKernelDetector::excite(std::size_t tracker, const Event& event, double fading) {
  Tracker& excited = trackers_[tracker];
  excited.most *= fading;  // rounding keeps the order of the activities
  const double dx = event.x - excited.x_px;
  const double dy = event.y - excited.y_px;
  const double distance_px = std::sqrt(dx * dx + dy * dy);
  // The kernels whose rings are near, and one more at each end for what rounding does.
  const double at = (distance_px - radii_px_.front()) * kernels_per_px_;
  const double kernels = reach_px_ * kernels_per_px_;
  const double nearest = at - kernels - 1.0;
  const double farthest = at + kernels + 2.0;
  const auto count = static_cast<double>(radii_px_.size());
  if (nearest >= count || farthest <= 0.0) return;
  excited.most =
      multi_kernel::add_values({activity(tracker), radii_px_.data(), values_.data(), values_per_kernel_},
                               static_cast<std::size_t>(std::max(nearest, 0.0)),
                               static_cast<std::size_t>(std::min(farthest, count)), distance_px);
}

/// Of an excited tracker to the event; at most its largest activity.
double MultiKernelDetector::response(std::size_t tracker, const Event& event) {
  const Tracker& of = trackers_[tracker];
  const double distance_px = std::hypot(event.x - of.x_px, event.y - of.y_px);
  const double off = (distance_px - best_radius_px(tracker)) / config_.ring_px;
  return of.most * std::exp(-off * off / 8);
}

void MultiKernelDetector::move(std::size_t tracker, double response, const Event& event) {
  Tracker& moved = trackers_[tracker];
  const double radius_px = best_radius_px(tracker);
  const double dx = event.x - moved.x_px;
  const double dy = event.y - moved.y_px;
  const double share = response / moved.most;
  const double nearer = 1.0 - aim * radius_px / std::max(1.0, std::hypot(dx, dy));
  moved.x_px += config_.pull * share * nearer * dx;
  moved.y_px += config_.pull * share * nearer * dy;
  for (std::size_t i = 0; i < trackers_.size(); ++i) {
    Tracker& other = trackers_[i];
    const double apart_px = std::hypot(other.x_px - moved.x_px, other.y_px - moved.y_px);
    if (i == tracker || apart_px >= radius_px) continue;
    const std::size_t weaker = other.most < moved.most ? i : tracker;
    std::ranges::fill(activity(weaker), 0.0);
    trackers_[weaker].most = 0.0;
    return_to_grid(trackers_[weaker]);
  }
}

void MultiKernelDetector::process(std::span<const Event> events, const CameraMotion*) {
  for (const Event& event : events) {
    if (!sieve_.accept(event)) continue;
    const double age_us = static_cast<double>(event.t_us) - static_cast<double>(last_us_);
    const double fading = std::exp(-age_us / config_.decay_us);
    last_us_ = event.t_us;
    now_us_ = std::max(now_us_, event.t_us);
    multi_kernel::fade(activity_, fading);
    std::optional<std::size_t> winner;
    double most = 0.0;
    for (std::size_t i = 0; i < trackers_.size(); ++i) {
      excite(i, event, fading);
      if (trackers_[i].most > most) {
        if (const double value = response(i, event); value > most) {
          most = value;
          winner = i;
        }
      }
      if (trackers_[i].most < least_activity) return_to_grid(trackers_[i]);
    }
    if (winner && trackers_[*winner].most >= least_activity) move(*winner, most, event);
  }
}

void MultiKernelDetector::advance_to(std::int64_t now_us, const CameraMotion*) {
  now_us_ = std::max(now_us_, now_us);
}

Estimate MultiKernelDetector::estimate() {
  const auto best = std::ranges::max_element(trackers_, {}, &Tracker::most);
  const double age_us = static_cast<double>(now_us_) - static_cast<double>(last_us_);
  const double score = best->most * std::exp(-age_us / config_.decay_us);
  if (score < least_activity) return {};
  const double radius_px = best_radius_px(static_cast<std::size_t>(best - trackers_.begin()));
  return {true, false, {best->x_px, best->y_px, radius_px}, score};
}

}  // namespace saccade
