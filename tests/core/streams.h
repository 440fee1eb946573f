#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <string>
#include <string_view>
#include <vector>

#include "core/event.h"
#include "core/random.h"

/// Seeded event streams whose geometry is known, for the tests and benchmarks of core.
namespace saccade::streams {

inline void sort_by_time(std::vector<Event>& events) {
  std::stable_sort(events.begin(), events.end(),
                   [](const Event& a, const Event& b) { return a.t_us < b.t_us; });
}

inline Event event_at(std::int64_t t_us, int x, int y, bool on) {
  return {t_us, static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y), on, 0};
}

/// Shifts of time, in whole ms, that take a stream of at most `duration_us` from 0 to the earliest and to the latest
/// time stamps that 64 bits hold.
inline std::array<std::int64_t, 2> shifts_to_the_ends_of_time(std::int64_t duration_us) {
  constexpr std::int64_t ms = 1'000;
  return {std::numeric_limits<std::int64_t>::min() / ms * ms,
          (std::numeric_limits<std::int64_t>::max() / ms - duration_us / ms - 1) * ms};
}

inline std::vector<Event> shifted(std::vector<Event> events, std::int64_t by_us) {
  for (Event& e : events) e.t_us += by_us;
  return events;
}

/// Events anywhere in the image, 0 to 7 us apart.
inline std::vector<Event> random(ImageSize size, std::size_t count, std::uint64_t seed) {
  const RandomStream random(seed, "random");
  std::vector<Event> events;
  std::int64_t t = 0;
  for (std::size_t i = 0; i < count; ++i) {
    t += static_cast<std::int64_t>(random.bits(0, i) % 8);
    events.push_back(event_at(t, static_cast<int>(random.uniform(1, i) * size.width),
                              static_cast<int>(random.uniform(2, i) * size.height),
                              random.uniform(3, i) < 0.5));
  }
  return events;
}

/// Bursts of 20 events inside squares of 4 pixels: many votes in few cells, many ties.
inline std::vector<Event> clustered(ImageSize size, std::size_t count, std::uint64_t seed) {
  const RandomStream random(seed, "clustered");
  std::vector<Event> events = streams::random(size, count, seed);
  for (std::size_t i = 0; i < count; ++i) {
    const auto corner = [&](int stream, int length) {
      return static_cast<int>(random.uniform(static_cast<std::uint64_t>(stream), i / 20) * (length - 3));
    };
    events[i].x = static_cast<std::uint16_t>(corner(0, size.width) + static_cast<int>(random.bits(2, i) % 4));
    events[i].y =
        static_cast<std::uint16_t>(corner(1, size.height) + static_cast<int>(random.bits(3, i) % 4));
  }
  return events;
}

/// Events within two pixels of the image's border, where a ring reaches furthest outside.
inline std::vector<Event> border_hugging(ImageSize size, std::size_t count, std::uint64_t seed) {
  const RandomStream random(seed, "border");
  std::vector<Event> events = streams::random(size, count, seed);
  for (std::size_t i = 0; i < count; ++i) {
    const int depth = static_cast<int>(random.bits(0, i) % 2);
    const auto side = random.bits(1, i) % 4;
    if (side == 0) events[i].x = static_cast<std::uint16_t>(depth);
    if (side == 1) events[i].x = static_cast<std::uint16_t>(size.width - 1 - depth);
    if (side == 2) events[i].y = static_cast<std::uint16_t>(depth);
    if (side == 3) events[i].y = static_cast<std::uint16_t>(size.height - 1 - depth);
  }
  return events;
}

/// A straight edge that moves along (cos, sin) of `angle_rad` from corner to corner: every pixel fires once,
/// when the edge passes its centre.
inline std::vector<Event> moving_edge(ImageSize size, double angle_rad, double speed_px_s, bool on) {
  const double nx = std::cos(angle_rad);
  const double ny = std::sin(angle_rad);
  const double start = std::min(0.0, nx * (size.width - 1)) + std::min(0.0, ny * (size.height - 1));
  std::vector<Event> events;
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      events.push_back(event_at(std::llround((nx * x + ny * y - start) / speed_px_s * 1e6), x, y, on));
    }
  }
  sort_by_time(events);
  return events;
}

/// A bright disc whose centre moves in a straight line: every pixel fires ON when the outline enters it and
/// OFF when it leaves, inside [0, duration_s].
struct MovingDisc {
  double x_px, y_px;        ///< centre at time 0
  double vx_px_s, vy_px_s;  ///< velocity
  double r_px;

  [[nodiscard]] double x_at(std::int64_t t_us) const {
    return x_px + vx_px_s * static_cast<double>(t_us) * 1e-6;
  }
  [[nodiscard]] double y_at(std::int64_t t_us) const {
    return y_px + vy_px_s * static_cast<double>(t_us) * 1e-6;
  }

  [[nodiscard]] std::vector<Event> events(ImageSize size, double duration_s) const {
    std::vector<Event> events;
    const double v2 = vx_px_s * vx_px_s + vy_px_s * vy_px_s;
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) {
        // |p - c - v t|^2 = r^2
        const double dx = x - x_px;
        const double dy = y - y_px;
        const double along = dx * vx_px_s + dy * vy_px_s;
        const double root = along * along - v2 * (dx * dx + dy * dy - r_px * r_px);
        if (root <= 0.0) continue;
        for (const bool on : {true, false}) {
          const double t = (along + (on ? -1.0 : 1.0) * std::sqrt(root)) / v2;
          if (t >= 0.0 && t <= duration_s) events.push_back(event_at(std::llround(t * 1e6), x, y, on));
        }
      }
    }
    sort_by_time(events);
    return events;
  }
};

/// Discs of changing size and heading, 100 ms each, among short edges that sweep here and there: `ball_share`
/// of the events are a disc's.
inline std::vector<Event> cluttered(ImageSize size, std::size_t count, double ball_share,
                                    std::uint64_t seed) {
  const RandomStream random(seed, "cluttered");
  std::vector<Event> events;
  const double w = size.width;
  const double h = size.height;
  std::int64_t t0 = 0;
  for (std::uint64_t pass = 0; events.size() < count; ++pass) {
    const double r = random.uniform(12.0, 30.0, 0, pass);
    const double angle = random.uniform(0.0, 2.0 * std::numbers::pi, 1, pass);
    const MovingDisc disc{w / 2 - 20 * std::cos(angle), h / 2 - 20 * std::sin(angle), 400 * std::cos(angle),
                          400 * std::sin(angle), r};
    std::vector<Event> batch = disc.events(size, 0.1);
    const auto ball = static_cast<double>(batch.size());
    // Short straight edges of 6 pixels, each swept over 6 pixels in 15 ms.
    for (std::uint64_t edge = 0; static_cast<double>(batch.size()) < ball / ball_share; ++edge) {
      const auto of = [&](std::uint64_t which) { return random.uniform(pass * 8 + which + 16, edge); };
      const double turn = of(0) * 2.0 * std::numbers::pi;
      for (int i = 0; i < 36; ++i) {
        const int along = i % 6;
        const int across = i / 6;
        const int x = static_cast<int>(of(1) * w + along * std::cos(turn) - across * std::sin(turn));
        const int y = static_cast<int>(of(2) * h + along * std::sin(turn) + across * std::cos(turn));
        if (!size.contains(x, y)) continue;
        batch.push_back(
            event_at(std::llround(of(3) * 85'000 + across * 2'500 + along * 20), x, y, of(4) < 0.5));
      }
    }
    sort_by_time(batch);
    for (Event& e : batch) e.t_us += t0;
    t0 += 100'000;
    events.insert(events.end(), batch.begin(), batch.end());
  }
  events.resize(count);
  return events;
}

/// Every kind that stresses a transform, by name.
inline std::vector<Event> named(std::string_view kind, ImageSize size, std::size_t count,
                                std::uint64_t seed) {
  if (kind == "random") return random(size, count, seed);
  if (kind == "clustered") return clustered(size, count, seed);
  return border_hugging(size, count, seed);
}

}  // namespace saccade::streams
