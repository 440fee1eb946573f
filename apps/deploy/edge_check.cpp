#include "apps/deploy/edge_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "session/interrupt.h"

namespace saccade {
namespace {

constexpr std::int64_t look_us = 10'000;
constexpr std::int64_t rest_us = 1'000'000;
constexpr std::int64_t edge_us = 30'000;  // an edge that crosses 304 pixels in 3 s crosses three within it
constexpr int edge_neighbours = 3;
constexpr double most_at_rest =
    0.01;  // of the pixels; noise of 1 Hz per pixel makes less than .001 in a second
constexpr double least_crossed = 0.05;
constexpr double enough_crossed = 0.2;
constexpr double least_agreement = 0.8;

using Cameras = std::array<EdgePolarity, 2>;

double crossed(const EdgePolarity& camera, ImageSize size) {
  return static_cast<double>(camera.on() + camera.off()) / size.pixels();
}

/// Shows the events of a time to both cameras, until `is_enough`. Returns false if the camera ended before.
template <typename IsEnough>
bool watch(Robot& robot, std::int64_t span_us, Cameras& cameras, IsEnough is_enough) {
  Clock& clock = robot.clock();
  const std::int64_t end_us = clock.now_us() + span_us;
  std::vector<Event> events;
  while (clock.now_us() < end_us && !interrupted() && !is_enough()) {
    if (clock.wait_until(clock.now_us() + look_us) != PortStatus::ok) return false;
    events.clear();
    if (robot.events().read_until(clock.now_us(), events) != PortStatus::ok) return false;
    for (const Event& event : events) cameras[event.camera != 0 ? 1 : 0].add(event);
  }
  return true;
}

StartUpCheck verdict(const char* eye, const EdgePolarity& camera, ImageSize size, const std::string& remedy) {
  const std::int64_t pixels = camera.on() + camera.off();
  StartUpCheck check{fmt::format("ON means brighter ({} camera)", eye), false, {}};
  if (crossed(camera, size) < least_crossed) {
    check.found = fmt::format("the edge crossed {} of {} pixels, expected {} or more", pixels, size.pixels(),
                              std::llround(std::ceil(least_crossed * size.pixels())));
    return check;
  }
  const double on = static_cast<double>(camera.on()) / static_cast<double>(pixels);
  check.passed = on >= least_agreement;
  check.found = fmt::format("the brighter edge made ON at {:.0f} % of {} pixels", 100.0 * on, pixels);
  if (on <= 1.0 - least_agreement)
    check.found += ": ON means darker (or what was moved was darker than all behind it); " + remedy;
  else if (!check.passed)
    check.found += fmt::format(
        ", expected {:.0f} % or more: move something that is brighter than all behind it, and only in one "
        "direction",
        100.0 * least_agreement);
  return check;
}

}  // namespace

EdgePolarity::EdgePolarity(ImageSize size)
    : size_(size),
      newest_us_(2 * static_cast<std::size_t>(size.pixels()), INT64_MIN / 2),
      is_decided_(static_cast<std::size_t>(size.pixels()), 0) {}

void EdgePolarity::add(const Event& event) {
  const std::size_t pixel =
      static_cast<std::size_t>(event.y) * static_cast<std::size_t>(size_.width) + event.x;
  has_events_ = true;
  newest_us_[pixel + (event.on ? is_decided_.size() : 0)] = event.t_us;
  if (is_decided_[pixel] != 0 || !is_of_an_edge(event)) return;
  is_decided_[pixel] = 1;
  ++(event.on ? on_ : off_);
}

bool EdgePolarity::is_of_an_edge(const Event& event) const {
  const std::size_t half = event.on ? is_decided_.size() : 0;
  int neighbours = 0;
  for (int y = event.y - 1; y <= event.y + 1; ++y) {
    for (int x = event.x - 1; x <= event.x + 1; ++x) {
      if (!size_.contains(x, y) || (x == event.x && y == event.y)) continue;
      const std::size_t pixel =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(size_.width) + static_cast<std::size_t>(x);
      neighbours += newest_us_[half + pixel] >= event.t_us - edge_us;
    }
  }
  return neighbours >= edge_neighbours;
}

std::vector<StartUpCheck> edge_checks(Robot& robot, double longest_s, const std::string& remedy) {
  const ImageSize size = robot.events().image_size();
  const auto failed = [](std::string found) {
    return std::vector<StartUpCheck>{{"ON means brighter", false, std::move(found)}};
  };
  fmt::print(stderr, "polarity: keep all still before the camera\n");
  Cameras rest{EdgePolarity(size), EdgePolarity(size)};
  if (!watch(robot, rest_us, rest, [] { return false; })) return failed("the camera ended");
  const double at_rest = std::max(crossed(rest[0], size), crossed(rest[1], size));
  if (at_rest > most_at_rest) {
    return failed(
        fmt::format("edges moved at {:.1f} % of the pixels before anything was to move, expected at most "
                    "{:g}: a scene at "
                    "rest, without flickering light",
                    100.0 * at_rest, 100.0 * most_at_rest));
  }
  fmt::print(stderr,
             "polarity: move a white sheet into the image, in front of something darker, within {:g} s\n",
             longest_s);
  Cameras cameras{EdgePolarity(size), EdgePolarity(size)};
  const auto has_right = [&] { return rest[1].has_events() || cameras[1].has_events(); };
  const bool came_to_end = watch(robot, std::llround(1e6 * longest_s), cameras, [&] {
    return crossed(cameras[0], size) >= enough_crossed &&
           (!has_right() || crossed(cameras[1], size) >= enough_crossed);
  });
  if (!came_to_end) return failed("the camera ended");
  std::vector<StartUpCheck> checks{verdict("left", cameras[0], size, remedy)};
  if (has_right()) checks.push_back(verdict("right", cameras[1], size, remedy));
  return checks;
}

}  // namespace saccade
