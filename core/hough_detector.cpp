#include "core/hough_detector.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace saccade {
namespace {

constexpr std::int16_t whole_ring = -1;
constexpr std::int16_t no_vote = -2;

HoughDetectorConfig checked(HoughDetectorConfig config) {
  check_config("detector", config);
  if (!config.directed) {  // neither is used, nor was it checked
    config.arc_deg = HoughDetectorConfig{}.arc_deg;
    config.flow = {};
  }
  return config;
}

}  // namespace

void describe(FieldVisitor& v, HoughDetectorConfig& config) {
  v.reals("radius_px", config.radius_px, 2, {1, 255}, "smallest and largest radius, whole pixels");
  const auto& r = config.radius_px;
  v.require(r.size() != 2 || (r[0] <= r[1] && r[0] == std::floor(r[0]) && r[1] == std::floor(r[1])),
            "radius_px", r.size() == 2 ? "[" + text_of(r[0]) + ", " + text_of(r[1]) + "]" : "",
            "two whole numbers, the smaller one first");
  v.section(
      "window",
      [&](FieldVisitor& w) {
        w.integer("events", config.window_events, {1, 60000}, "how many of the newest events vote");
      },
      "what votes");
  if (config.directed) {
    v.real("arc_deg", config.arc_deg, {0.5, 90.0}, "half-width of an arc of votes");
    v.section(
        "flow", [&](FieldVisitor& w) { describe(w, config.flow); }, "plane-fit flow");
  }
  v.real("threshold", config.threshold, {0.0, 1e6}, "response taken for the ball");
}

HoughDetector::HoughDetector(const HoughDetectorConfig& config, ImageSize size)
    : config_(checked(config)),
      size_(size),
      flow_(config_.flow, size),
      transform_(size, static_cast<int>(config_.radius_px[0]), static_cast<int>(config_.radius_px[1]),
                 config_.arc_deg * std::numbers::pi / 180.0),
      ring_(static_cast<std::size_t>(2 * config_.window_events)),
      newest_us_(std::numeric_limits<std::int64_t>::min()) {}

std::int64_t HoughDetector::count_acceptable(std::span<const Event> events) const {
  std::int64_t count = 0;
  std::int64_t newest = newest_us_;
  for (const Event& event : events) {
    if (event.x >= size_.width || event.y >= size_.height || event.t_us < newest) continue;
    newest = event.t_us;
    ++count;
  }
  return count;
}

void HoughDetector::process(std::span<const Event> events, const CameraMotion*) {
  const std::int64_t outlives_batch = received_ + count_acceptable(events) - config_.window_events;
  for (const Event& event : events) {
    if (event.x >= size_.width || event.y >= size_.height) {
      ++rejected_.outside_image;
      continue;
    }
    if (event.t_us < newest_us_) {
      ++rejected_.back_in_time;
      continue;
    }
    newest_us_ = event.t_us;
    const std::int64_t number = received_++;
    Entry& slot = entry(number);
    slot = {event.x, event.y, config_.directed ? no_vote : whole_ring};
    if (!config_.directed) continue;
    flow_.add(event);
    // An event that has left the window by the end of this batch is needed for the surface alone.
    if (number < outlives_batch) continue;
    if (const auto flow = flow_.at(event)) {
      slot.direction =
          static_cast<std::int16_t>(HoughTransform::direction_of(flow->dt_dx_us_px, flow->dt_dy_us_px));
    }
  }
}

template <int sign>
void HoughDetector::vote(const Entry& e) {
  if (e.direction >= 0) transform_.vote_arcs<sign>(e.x, e.y, e.direction);
  if (e.direction == whole_ring) transform_.vote_ring<sign>(e.x, e.y);
}

Estimate HoughDetector::estimate() {
  if (voted_until_ == received_) return estimate_;
  const std::int64_t n = config_.window_events;
  const std::int64_t begin = std::max<std::int64_t>(0, received_ - n);
  if (begin >= voted_until_) {
    transform_.clear();
  } else {
    for (std::int64_t i = std::max<std::int64_t>(0, voted_until_ - n); i < begin; ++i) vote<-1>(entry(i));
  }
  for (std::int64_t i = std::max(begin, voted_until_); i < received_; ++i) vote<1>(entry(i));
  voted_until_ = received_;
  const HoughTransform::Peak peak = transform_.peak();
  estimate_ = {true,
               false,
               {static_cast<double>(peak.x), static_cast<double>(peak.y), static_cast<double>(peak.r)},
               peak.response};
  return estimate_;
}

}  // namespace saccade
