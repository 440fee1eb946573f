#include "evaluation/sensor_fit/stimulus.h"

#include <algorithm>
#include <cmath>

namespace saccade {
namespace {

constexpr double largest_step_px = 0.2;
constexpr Range luminance_range{0.0, 1e9};

std::int64_t us(double seconds) { return std::llround(seconds * 1e6); }

/// The value of rows (t, ...) at t, straight between them and constant outside.
template <std::size_t n>
std::array<double, n> interpolated(const std::vector<std::array<double, n>>& rows, double t_s) {
  const auto after =
      std::upper_bound(rows.begin(), rows.end(), t_s, [](double t, const auto& row) { return t < row[0]; });
  if (after == rows.begin()) return rows.front();
  if (after == rows.end()) return rows.back();
  const auto& a = *std::prev(after);
  const double share = (t_s - a[0]) / ((*after)[0] - a[0]);
  std::array<double, n> at{};
  for (std::size_t i = 0; i < n; ++i) at[i] = a[i] + share * ((*after)[i] - a[i]);
  return at;
}

bool ascending(const auto& rows) {
  return std::adjacent_find(rows.begin(), rows.end(),
                            [](const auto& a, const auto& b) { return !(b[0] > a[0]); }) == rows.end();
}

void describe_panel(FieldVisitor& v, Stimulus& s) {
  v.reals("region_px", s.region_px, {0.0, 65535.0},
          "x and y of the panel's left top pixel, width and height; at most 50 pixels");
  v.choice("change", s.change, "luminance from one point to the next: constant, or a straight line");
  v.points("points", s.points, {0.0, 1e9}, "time in s and luminance from then on; ascending in time");
  v.real("period_s", s.period_s, {0.0, 1e6}, "time after which the points repeat; 0: they do not");
  const double pixels = s.region_px[2] * s.region_px[3];
  v.require(pixels >= 1.0 && pixels <= Stimulus::max_panel_pixels, "region_px", text_of(pixels) + " pixels",
            "1 to 50 pixels, so that the bus delays no event");
  v.require(s.points.size() >= 2 && ascending(s.points), "points",
            std::to_string(s.points.size()) + " points", "at least 2, ascending in time");
  v.require(s.period_s == 0.0 || s.points.empty() || s.period_s > s.points.back()[0], "period_s",
            text_of(s.period_s), "a time after the last point, or 0");
}

void describe_board(FieldVisitor& v, Stimulus& s) {
  v.integer("columns", s.columns, {1, 100}, "dots in a row");
  v.integer("rows", s.rows, {1, 100}, "rows of dots");
  v.real("spacing_px", s.spacing_px, {1.0, 1e4}, "from row to row, and half the way between dots of a row");
  v.real("dot_diameter_px", s.dot_diameter_px, {1.0, 1e4}, "diameter of a dot in the image");
  v.points("path", s.path, {-1e6, 1e6},
           "time in s and place of the first dot's centre in px; straight in between");
  v.require(s.path.size() >= 2 && ascending(s.path), "path", std::to_string(s.path.size()) + " points",
            "at least 2, ascending in time");
}

}  // namespace

void describe(FieldVisitor& v, Stimulus& s) {
  v.choice("kind", s.kind, "what was shown");
  v.integer("zero_us", s.zero_us, {-4e18, 4e18}, "time in the recording from which the times here count");
  if (v.fills_defaults()) s.from_s = s.until_s = std::nullopt;
  const auto from_s = v.alternative("from_s", {-1e9, 1e9}, "start of the part to use; its beginning");
  const auto until_s = v.alternative("until_s", {-1e9, 1e9}, "end of the part to use; its end");
  if (v.fills_defaults()) {
    s.from_s = from_s;
    s.until_s = until_s;
  }
  v.require(!s.from_s || !s.until_s || *s.until_s > *s.from_s, "until_s", text_of(s.until_s.value_or(0.0)),
            "a time after from_s");
  v.when(s.kind == StimulusKind::still, "kind: still",
         [&] { v.real("luminance", s.luminance, luminance_range, "luminance of the scene; 0 in the dark"); });
  v.when(s.kind == StimulusKind::panel, "kind: panel", [&] { describe_panel(v, s); });
  v.when(s.kind == StimulusKind::board, "kind: board", [&] { describe_board(v, s); });
  v.when(s.kind == StimulusKind::disc, "kind: disc", [&] {
    v.path("circles", s.circles_file, "table t_us,x_px,y_px,r_px of the disc, in the recording's clock");
    v.boolean("known_contrast", s.known_contrast, "whether dark and light were measured");
    v.require(!s.circles_file.empty(), "circles", "none", "the name of a file");
  });
  v.when(s.kind == StimulusKind::board || s.kind == StimulusKind::disc, "kind: board or disc", [&] {
    v.real("dark", s.dark, luminance_range, "luminance of the dots or the disc");
    v.real("light", s.light, luminance_range, "luminance around them");
    v.real("blur_px", s.blur_px, {0.0, 100.0}, "width of an edge in the image, beyond that of a pixel");
    v.require(s.dark != s.light, "light", text_of(s.light), "another luminance than dark");
  });
  v.when(s.kind != StimulusKind::panel, "kind: still or board or disc", [&] {
    v.reals("region_px", s.region_px, {0.0, 65535.0},
            "pixels to use: x and y of the left top one, width and height; a width of 0: all");
  });
}

void describe(FieldVisitor& v, StimulusFile& file) {
  v.real("white", file.white, {1e-6, 1e9}, "luminance of white, the unit of all luminances");
  v.real("dark_current", file.dark_current, luminance_range, "added to the luminance by the sensor");
  v.named_sections("stimuli", file.stimuli, "what each recording shows",
                   "a recording, by its name without extension");
}

StimulusInterval interval_of(const Stimulus& s, std::int64_t first_us, std::int64_t last_us) {
  StimulusInterval whole{first_us, last_us};
  if (s.kind == StimulusKind::board) {
    whole = {s.zero_us + us(s.path.front()[0]), s.zero_us + us(s.path.back()[0])};
  } else if (s.kind == StimulusKind::disc && !s.circles.empty()) {
    whole = {s.circles.front().t_us, s.circles.back().t_us};
  } else if (s.kind == StimulusKind::panel) {
    whole = {s.zero_us + us(s.points.front()[0]),
             s.period_s > 0.0 ? last_us : std::min(last_us, s.zero_us + us(s.points.back()[0]) + 1'000'000)};
    if (s.period_s > 0.0) {  // whole periods
      const std::int64_t period_us = us(s.period_s);
      whole.end_us = s.zero_us + (last_us + 1 - s.zero_us) / period_us * period_us;
    }
  }
  if (s.from_s) whole.begin_us = std::max(whole.begin_us, s.zero_us + us(*s.from_s));
  if (s.until_s) whole.end_us = std::min(whole.end_us, s.zero_us + us(*s.until_s));
  return whole;
}

std::vector<PanelStep> steps_of(const Stimulus& s) {
  std::vector<PanelStep> steps;
  const bool repeats = s.period_s > 0.0;
  const bool linear = s.change == PanelChange::linear;
  for (std::size_t i = 0; i < s.points.size(); ++i) {
    const bool last = i + 1 == s.points.size();
    if (i == 0 && !repeats && !linear) continue;  // nothing changes at the first point
    if (last && linear) break;
    const double until_s =
        last ? (repeats ? s.period_s + s.points.front()[0] : s.points[i][0] + 1.0) : s.points[i + 1][0];
    const double before = linear ? s.points[i][1] : (i == 0 ? s.points.back() : s.points[i - 1])[1];
    const double after = linear ? s.points[i + 1][1] : s.points[i][1];
    steps.push_back({s.points[i][0], until_s, before, after});
  }
  return steps;
}

std::vector<std::int64_t> image_times_us(const Stimulus& s, StimulusInterval interval) {
  const std::int64_t end_us = interval.end_us - interval.begin_us;
  std::vector<std::int64_t> times = {0};
  const auto put = [&](std::int64_t t_us) {
    if (t_us > times.back() && t_us <= end_us) times.push_back(t_us);
  };
  /// Images between two instants while something moves by `distance_px`.
  const auto between = [&](std::int64_t from_us, std::int64_t to_us, double distance_px) {
    const auto steps = static_cast<std::int64_t>(std::ceil(distance_px / largest_step_px));
    for (std::int64_t k = 1; k <= steps; ++k) {
      put(from_us + (to_us - from_us) * k / steps - interval.begin_us);
    }
    put(to_us - interval.begin_us);
  };
  if (s.kind == StimulusKind::board) {
    for (std::size_t i = 1; i < s.path.size(); ++i) {
      between(s.zero_us + us(s.path[i - 1][0]), s.zero_us + us(s.path[i][0]),
              std::hypot(s.path[i][1] - s.path[i - 1][1], s.path[i][2] - s.path[i - 1][2]));
    }
  } else if (s.kind == StimulusKind::disc) {
    for (std::size_t i = 1; i < s.circles.size(); ++i) {
      const Circle& a = s.circles[i - 1].circle;
      const Circle& b = s.circles[i].circle;
      between(s.circles[i - 1].t_us, s.circles[i].t_us,
              std::hypot(b.x_px - a.x_px, b.y_px - a.y_px) + std::abs(b.r_px - a.r_px));
    }
  } else if (s.kind == StimulusKind::panel) {
    constexpr int parts = 20;  // of a straight line in luminance, which is none in its logarithm
    const std::int64_t period_us = s.period_s > 0.0 ? us(s.period_s) : std::max<std::int64_t>(1, end_us) * 2;
    std::int64_t start_us = s.zero_us - interval.begin_us;
    start_us -= (start_us / period_us + 1) * period_us;
    for (; start_us <= end_us; start_us += period_us) {
      for (std::size_t i = 0; i < s.points.size(); ++i) {
        const std::int64_t t_us = start_us + us(s.points[i][0]);
        if (s.change == PanelChange::step) put(t_us - 1);
        put(t_us);
        if (s.change == PanelChange::step || i + 1 == s.points.size()) continue;
        const std::int64_t next_us = start_us + us(s.points[i + 1][0]);
        for (int k = 1; k < parts; ++k) put(t_us + (next_us - t_us) * k / parts);
      }
    }
  }
  put(end_us);
  return times;
}

ShownStimulus::ShownStimulus(const Stimulus& stimulus, double contrast_scale)
    : stimulus_(stimulus),
      dark_(stimulus.light > 0.0 && stimulus.dark > 0.0
                ? stimulus.light * std::pow(stimulus.dark / stimulus.light, contrast_scale)
                : stimulus.dark),
      level_(stimulus.luminance) {}

void ShownStimulus::move_to(std::int64_t t_us) {
  double t_s = static_cast<double>(t_us - stimulus_.zero_us) * 1e-6;
  if (stimulus_.kind == StimulusKind::board) {
    const auto at = interpolated(stimulus_.path, t_s);
    at_ = {at[1], at[2]};
  } else if (stimulus_.kind == StimulusKind::panel) {
    constexpr double rounding_s = 0.5e-6;
    const auto& points = stimulus_.points;
    if (stimulus_.period_s > 0.0)
      t_s -= std::floor((t_s + rounding_s) / stimulus_.period_s) * stimulus_.period_s;
    const auto after = std::upper_bound(points.begin(), points.end(), t_s + rounding_s,
                                        [](double t, const auto& point) { return t < point[0]; });
    const auto& before = after == points.begin() ? (stimulus_.period_s > 0.0 ? points.back() : points.front())
                                                 : *std::prev(after);
    level_ = stimulus_.change == PanelChange::step ? before[1] : interpolated(points, t_s)[1];
  } else if (stimulus_.kind == StimulusKind::disc && !stimulus_.circles.empty()) {
    const auto& circles = stimulus_.circles;
    const auto after = std::upper_bound(circles.begin(), circles.end(), t_us,
                                        [](std::int64_t t, const TimedCircle& c) { return t < c.t_us; });
    if (after == circles.begin() || after == circles.end()) {
      circle_ = (after == circles.begin() ? circles.front() : circles.back()).circle;
      return;
    }
    const TimedCircle& a = *std::prev(after);
    const double share = static_cast<double>(t_us - a.t_us) / static_cast<double>(after->t_us - a.t_us);
    const auto mixed = [&](double Circle::*m) {
      return a.circle.*m + share * (after->circle.*m - a.circle.*m);
    };
    circle_ = {mixed(&Circle::x_px), mixed(&Circle::y_px), mixed(&Circle::r_px)};
  }
}

double ShownStimulus::dark_share(double dx_px, double dy_px, double radius_px) const {
  // The outline is straight within a pixel: over the square pixel its share grows as the sum of two uniform
  // distributions does, of the widths of the square's sides seen across the outline.
  const double distance_px = std::hypot(dx_px, dy_px);
  const double edge_px = std::hypot(1.0, stimulus_.blur_px);
  const double x = distance_px > 0.0 ? std::abs(dx_px) / distance_px : 1.0;
  const double y = distance_px > 0.0 ? std::abs(dy_px) / distance_px : 0.0;
  const double wide = edge_px * std::max(x, y);
  const double narrow = edge_px * std::min(x, y);
  const double inside_px = radius_px - distance_px;
  const double to_end_px = 0.5 * (wide + narrow) - std::abs(inside_px);
  if (to_end_px <= 0.0) return inside_px > 0.0 ? 1.0 : 0.0;
  const double less =
      to_end_px < narrow ? to_end_px * to_end_px / (2.0 * wide * narrow) : (to_end_px - 0.5 * narrow) / wide;
  return inside_px > 0.0 ? 1.0 - less : less;
}

float ShownStimulus::luminance(double x, double y) const {
  double share = 0.0;
  if (stimulus_.kind == StimulusKind::board) {
    // The dots of the three rows around the pixel, in each of them the nearest one.
    const double v = (y - at_[1]) / stimulus_.spacing_px;
    const double u = (x - at_[0]) / stimulus_.spacing_px;
    const auto middle = static_cast<std::int64_t>(std::llround(v));
    for (std::int64_t row = middle - 1; row <= middle + 1; ++row) {
      if (row < 0 || row >= stimulus_.rows) continue;
      const auto odd = static_cast<double>(row % 2);
      const auto column = std::clamp<std::int64_t>(std::llround((u - odd) / 2.0), 0, stimulus_.columns - 1);
      const double dx = u - odd - 2.0 * static_cast<double>(column);
      const double dy = v - static_cast<double>(row);
      share = std::max(share, dark_share(stimulus_.spacing_px * dx, stimulus_.spacing_px * dy,
                                         0.5 * stimulus_.dot_diameter_px));
    }
  } else if (stimulus_.kind == StimulusKind::disc) {
    share = dark_share(x - circle_.x_px, y - circle_.y_px, circle_.r_px);
  } else {
    return static_cast<float>(level_);
  }
  return static_cast<float>(stimulus_.light + share * (dark_ - stimulus_.light));
}

}  // namespace saccade
