#include "core/baselines/original_2016.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/time_stamp.h"

namespace saccade {
namespace {

constexpr std::int64_t no_event_us = std::numeric_limits<std::int64_t>::min();
constexpr double ring_width_px = 0.4;  // outside of the radius; as in the program of 2016

}  // namespace

void describe(FieldVisitor& v, Original2016Config& config) {
  describe_radius_px(v, config.radius_px);
  v.section(
      "window",
      [&](FieldVisitor& w) {
        w.integer("events", config.window_events, {1, 60000}, "events with flow that vote");
      },
      "what votes");
  v.real("arc_deg", config.arc_deg, {0.5, 90.0}, "half-width of an arc of votes");
  v.section(
      "flow",
      [&](FieldVisitor& w) {
        w.integer("min_inliers", config.min_inliers, {3, 9},
                  "least number of inliers among the nine events of a patch");
      },
      "flow by patches of 3 x 3 pixels");
  v.choice("maximum", config.maximum, "rule for the best cell of a radius");
  v.real("threshold", config.threshold, {0.0, 1e6}, "least response that is taken for the ball");
}

std::string window_text(const Original2016Config& config) {
  return std::to_string(config.window_events) + " events";
}

Original2016::Original2016(const Original2016Config& config, ImageSize size)
    : config_(config), exact_maximum_(config.maximum == MaximumSearch::exact), size_(size), sieve_(size) {
  check_config("detector", config);
  const auto pixels = static_cast<std::size_t>(size.pixels());
  for (auto& surface : surface_) surface.assign(pixels, no_event_us);
  window_.resize(pixels);
  for (int r = static_cast<int>(config.radius_px[0]); r <= static_cast<int>(config.radius_px[1]); ++r) {
    tabulate(r);
  }
}

/// Appends a radius.
void Original2016::tabulate(int r_px) {
  Radius& radius = radii_.emplace_back();
  radius.r_px = r_px;
  radius.votes.assign(static_cast<std::size_t>(size_.pixels()), 0);
  for (int dy = -r_px - 1; dy <= r_px + 1; ++dy) {
    for (int dx = -r_px - 1; dx <= r_px + 1; ++dx) {
      const double outside_px = std::hypot(dx, dy) - r_px;
      if (outside_px < 0.0 || outside_px > ring_width_px) continue;
      ++radius.ring_pixels;
      const double angle_deg = std::atan2(dy, dx) * 180.0 / std::numbers::pi;
      for (int d = 0; d < direction_count; ++d) {
        const double off_deg = std::abs(std::remainder(angle_deg - d, 180.0));
        if (off_deg <= config_.arc_deg)
          arcs_[static_cast<std::size_t>(d)].offsets.push_back({dx, dy, pixel(dx, dy)});
      }
    }
  }
  for (Arcs& arcs : arcs_) arcs.ends.push_back(arcs.offsets.size());
}

std::optional<NormalFlow> Original2016::flow_at(const Event& event) const {
  const auto& surface = surface_[event.on ? 1 : 0];
  // Sums over the freshest patch: of dt, and of dt times the column and the row of the patch.
  double best_dt = -std::numeric_limits<double>::infinity();
  int best_x = 0, best_y = 0;
  NormalFlow best;
  const auto dt_us = [&](int x, int y) {
    return static_cast<double>(
        saturated_difference(surface[static_cast<std::size_t>(pixel(x, y))], event.t_us));
  };
  for (int cy = event.y - 1; cy <= event.y + 1; ++cy) {
    for (int cx = event.x - 1; cx <= event.x + 1; ++cx) {
      if (!size_.contains(cx - 1, cy - 1) || !size_.contains(cx + 1, cy + 1)) continue;
      bool filled = true;
      double sum = 0, sum_x = 0, sum_y = 0;
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          filled = filled && surface[static_cast<std::size_t>(pixel(cx + dx, cy + dy))] != no_event_us;
          const double dt = dt_us(cx + dx, cy + dy);
          sum += dt;
          sum_x += dx * dt;
          sum_y += dy * dt;
        }
      }
      if (!filled || sum <= best_dt) continue;
      best_dt = sum;
      best_x = cx;
      best_y = cy;
      best = {sum_x / 6, sum_y / 6};
    }
  }
  const double slope = std::hypot(best.dt_dx_us_px, best.dt_dy_us_px);
  std::int64_t inliers = 0;
  for (int y = best_y - 1; slope > 0.0 && y <= best_y + 1; ++y) {
    for (int x = best_x - 1; x <= best_x + 1; ++x) {
      const double predicted = best.dt_dx_us_px * (x - event.x) + best.dt_dy_us_px * (y - event.y);
      inliers += std::abs(predicted - dt_us(x, y)) < slope / 2 ? 1 : 0;
    }
  }
  if (inliers < config_.min_inliers) return std::nullopt;
  return best;
}

/// Calls count(radius, cell) for each cell that an event votes for.
template <class Count>
void Original2016::for_votes(int pixel, int direction, const Count& count) {
  const int x = pixel % size_.width;
  const int y = pixel / size_.width;
  const Arcs& arcs = arcs_[static_cast<std::size_t>(direction)];
  std::size_t i = 0;
  for (std::size_t r = 0; r < radii_.size(); ++r) {
    Radius& radius = radii_[r];
    const int reach = radius.r_px + 1;
    const bool is_inside = size_.contains(x - reach, y - reach) && size_.contains(x + reach, y + reach);
    for (; i < arcs.ends[r]; ++i) {
      const Offset& offset = arcs.offsets[i];
      if (is_inside || size_.contains(x + offset.dx, y + offset.dy))
        count(radius, static_cast<std::size_t>(pixel + offset.at));
    }
  }
}

void Original2016::vote(int pixel, int direction) {
  for_votes(pixel, direction, [](Radius& radius, std::size_t at) {
    ++radius.votes[at];
    if (radius.votes[at] > radius.votes[radius.best]) radius.best = at;
  });
}

void Original2016::take_back(int pixel, int direction) {
  for_votes(pixel, direction, [](Radius& radius, std::size_t at) { --radius.votes[at]; });
}

void Original2016::enter(int pixel, int direction) {
  if (window_[static_cast<std::size_t>(pixel)].direction != none) leave(pixel);
  if (count_ == config_.window_events) leave(oldest_);
  if (newest_ != none) window_[static_cast<std::size_t>(newest_)].newer = pixel;
  if (oldest_ == none) oldest_ = pixel;
  window_[static_cast<std::size_t>(pixel)] = {newest_, none, direction};
  newest_ = pixel;
  ++count_;
  vote(pixel, direction);
}

void Original2016::leave(int pixel) {
  Member& gone = window_[static_cast<std::size_t>(pixel)];
  (gone.older != none ? window_[static_cast<std::size_t>(gone.older)].newer : oldest_) = gone.newer;
  (gone.newer != none ? window_[static_cast<std::size_t>(gone.newer)].older : newest_) = gone.older;
  take_back(pixel, gone.direction);
  gone = {};
  --count_;
}

void Original2016::process(std::span<const Event> events, const CameraMotion*) {
  for (const Event& event : events) {
    if (!sieve_.accept(event)) continue;
    const int at = pixel(event.x, event.y);
    surface_[event.on ? 1 : 0][static_cast<std::size_t>(at)] = event.t_us;
    const auto flow = flow_at(event);
    if (!flow) continue;
    const double angle_deg = std::atan2(flow->dt_dy_us_px, flow->dt_dx_us_px) * 180.0 / std::numbers::pi;
    enter(at, static_cast<int>(std::lround(angle_deg) + 2 * direction_count) % direction_count);
  }
}

Estimate Original2016::estimate() {
  Estimate best;
  for (Radius& radius : radii_) {
    if (exact_maximum_) {
      radius.best = static_cast<std::size_t>(std::max_element(radius.votes.begin(), radius.votes.end()) -
                                             radius.votes.begin());
    }
    const double response = radius.votes[radius.best] / radius.ring_pixels;
    if (response <= best.score) continue;
    const int at = static_cast<int>(radius.best);
    const int column = at % size_.width;
    const int row = at / size_.width;
    best = {true,
            false,
            {static_cast<double>(column), static_cast<double>(row), static_cast<double>(radius.r_px)},
            response};
  }
  return best;
}

bool Original2016::hough_space(std::span<float> response) const {
  SACCADE_CHECK(std::ssize(response) == size_.pixels());
  for (std::size_t i = 0; i < response.size(); ++i) {
    response[i] = 0.0F;
    for (const Radius& radius : radii_) {
      response[i] = std::max(response[i], static_cast<float>(radius.votes[i] / radius.ring_pixels));
    }
  }
  return true;
}

}  // namespace saccade
