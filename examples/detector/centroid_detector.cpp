#include "centroid_detector.h"

#include <algorithm>
#include <cmath>

namespace example {

void describe(saccade::FieldVisitor& v, CentroidConfig& config) {
  v.integer("events", config.events, {10, 1e5}, "number of events that the estimate is made of");
  v.real("threshold", config.threshold, {0.0, 1.0},
         "score at and above which the circle is taken for the ball");
}

std::string window_text(const CentroidConfig& config) { return std::to_string(config.events) + " events"; }

CentroidDetector::CentroidDetector(const CentroidConfig& config, saccade::ImageSize size)
    : config_(saccade::check_config("detector", config)),
      sieve_(size),
      newest_(static_cast<std::size_t>(config.events)) {}

void CentroidDetector::process(std::span<const saccade::Event> events, const saccade::CameraMotion*) {
  for (const saccade::Event& event : events) {
    if (!sieve_.accept(event)) continue;
    newest_[count_++ % newest_.size()] = {static_cast<double>(event.x), static_cast<double>(event.y)};
  }
}

saccade::Estimate CentroidDetector::estimate() {
  if (count_ < newest_.size()) return {};
  const auto n = static_cast<double>(newest_.size());
  saccade::Estimate estimate;
  estimate.valid = true;
  saccade::Circle& circle = estimate.circle;
  for (const Position& p : newest_) {
    circle.x_px += p.x_px / n;
    circle.y_px += p.y_px / n;
  }
  double squares = 0.0;
  for (const Position& p : newest_) {
    const double distance_px = std::hypot(p.x_px - circle.x_px, p.y_px - circle.y_px);
    circle.r_px += distance_px / n;
    squares += distance_px * distance_px / n;
  }
  const double deviation_px = std::sqrt(std::max(0.0, squares - circle.r_px * circle.r_px));
  estimate.score = circle.r_px > 0.0 ? std::max(0.0, 1.0 - deviation_px / circle.r_px) : 0.0;
  return estimate;
}

}  // namespace example
