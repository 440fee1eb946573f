#include "core/hough/hough_detector.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/units.h"

namespace saccade {
namespace {

bool uses_flow(const HoughDetectorConfig& config) {
  return config.directed || config.window.kind == WindowKind::lifetime;
}

HoughDetectorConfig checked(HoughDetectorConfig config) {
  check_config("detector", config);
  // What is not used was not checked.
  if (!config.directed) config.arc_deg = HoughDetectorConfig{}.arc_deg;
  if (!uses_flow(config)) config.flow = {};
  if (config.single_radius) {
    config.radius_px.fill(std::round((config.radius_px[0] + config.radius_px[1]) / 2));
  }
  return config;
}

}  // namespace

void describe(FieldVisitor& v, HoughDetectorConfig& config) {
  describe_radius_px(v, config.radius_px);
  v.section(
      "window", [&](FieldVisitor& w) { describe(w, config.window); }, "events that vote");
  v.choice("normalisation", config.normalisation, "divisor of the votes");
  if (config.directed) v.real("arc_deg", config.arc_deg, {0.5, 90.0}, "half-width of an arc of votes");
  if (uses_flow(config)) {
    v.section(
        "flow", [&](FieldVisitor& w) { describe(w, config.flow); }, "plane-fit flow");
  }
  v.real("threshold", config.threshold, {0.0, 1e6}, "least response that is taken for the ball");
}

std::string window_text(const HoughDetectorConfig& config) {
  const EventWindowConfig& window = config.window;
  if (window.kind == WindowKind::count) return std::to_string(window.events) + " events";
  if (window.kind == WindowKind::time) return text_of(static_cast<double>(window.duration_us) * 1e-3) + " ms";
  return std::string(word_of(window.kind));
}

HoughDetector::HoughDetector(const HoughDetectorConfig& config, ImageSize size)
    : config_(checked(config)),
      with_flow_(uses_flow(config_)),
      sieve_(size),
      flow_(config_.flow, size),
      window_(config_.window),
      transform_(size, static_cast<int>(config_.radius_px[0]), static_cast<int>(config_.radius_px[1]),
                 config_.arc_deg * rad_per_deg, config_.normalisation),
      now_us_(std::numeric_limits<std::int64_t>::min()) {}

void HoughDetector::process(std::span<const Event> events, const CameraMotion*) {
  const auto [count, newest_us] = sieve_.preview(events);
  now_us_ = std::max(now_us_, newest_us);
  std::int64_t newer = count;
  for (const Event& event : events) {
    if (!sieve_.accept(event)) continue;
    --newer;
    WindowEvent vote{event.x, event.y, HoughTransform::whole_ring};
    if (!with_flow_) {
      window_.push(event.t_us, vote, window_.lifetime_us({}));
      continue;
    }
    flow_.add(event);
    std::int64_t lifetime_us = 0;
    // An event that has left the window by the end of this batch is needed for the surface alone.
    if (!window_.outlived(event.t_us, newer, now_us_)) {
      const auto flow = flow_.at(event);
      if (flow && config_.directed) {
        vote.direction =
            static_cast<std::int16_t>(HoughTransform::direction_of(flow->dt_dx_us_px, flow->dt_dy_us_px));
      }
      if (flow || !config_.directed) lifetime_us = window_.lifetime_us(flow);
    }
    window_.push(event.t_us, vote, lifetime_us);
  }
}

void HoughDetector::advance_to(std::int64_t now_us, const CameraMotion*) {
  now_us_ = std::max(now_us_, now_us);
}

Estimate HoughDetector::estimate() {
  const EventWindow::Change change = window_.update(now_us_);
  if (change.none()) return estimate_;
  transform_.vote(change);
  const HoughTransform::Peak peak = transform_.peak();
  estimate_ = {};
  if (peak.votes == 0) return estimate_;
  estimate_ = {true,
               false,
               {static_cast<double>(peak.x), static_cast<double>(peak.y), static_cast<double>(peak.r)},
               peak.response};
  return estimate_;
}

bool HoughDetector::hough_space(std::span<float> response) const {
  largest_response(transform_, response);
  return true;
}

}  // namespace saccade
