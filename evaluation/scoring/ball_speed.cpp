#include "evaluation/scoring/ball_speed.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "evaluation/scoring/scoring.h"

namespace saccade {
namespace {

constexpr std::int64_t reach_us = 5'000;
constexpr double chances_per_s = 1'000.0;

}  // namespace

std::vector<double> image_speed_px_s(std::span<const TruthRow> truth) {
  std::vector<double> speed_px_s(truth.size(), std::numeric_limits<double>::quiet_NaN());
  std::size_t stretch_start = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (!has_circle(truth[i])) {
      stretch_start = i + 1;
      continue;
    }
    std::size_t first = i;
    while (first > stretch_start && truth[i].t_us - truth[first - 1].t_us <= reach_us) --first;
    std::size_t last = i;
    while (last + 1 < truth.size() && has_circle(truth[last + 1]) &&
           truth[last + 1].t_us - truth[i].t_us <= reach_us) {
      ++last;
    }
    if (first == last) continue;
    const Circle& a = truth[first].circle;
    const Circle& b = truth[last].circle;
    speed_px_s[i] = std::hypot(b.x_px - a.x_px, b.y_px - a.y_px) * 1e6 /
                    static_cast<double>(truth[last].t_us - truth[first].t_us);
  }
  return speed_px_s;
}

void SpeedCounts::add(std::span<const std::optional<bool>> found_at, std::span<const double> speed_px_s) {
  SACCADE_CHECK(found_at.size() == speed_px_s.size());
  for (std::size_t i = 0; i < found_at.size(); ++i) {
    if (!found_at[i] || !std::isfinite(speed_px_s[i])) continue;
    const auto above = std::upper_bound(bounds_px_s.begin(), bounds_px_s.end(), speed_px_s[i]);
    const auto bin = static_cast<std::size_t>(above - bounds_px_s.begin()) - 1;
    ++chances[bin];
    found[bin] += *found_at[i] ? 1 : 0;
  }
}

std::optional<double> SpeedCounts::rate_hz(std::size_t bin) const {
  if (chances[bin] < enough_chances) return std::nullopt;
  return chances_per_s * static_cast<double>(found[bin]) / static_cast<double>(chances[bin]);
}

}  // namespace saccade
