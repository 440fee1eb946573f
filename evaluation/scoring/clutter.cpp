#include "evaluation/scoring/clutter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "emulator/event_label.h"
#include "evaluation/scoring/scoring.h"

namespace saccade {
namespace {

template <std::size_t n>
std::size_t index_of(const std::array<std::string_view, n>& names, const std::string& name,
                     const char* column) {
  const auto at = std::find(names.begin(), names.end(), name);
  if (at == names.end())
    throw InputError(std::string("labels, column ") + column, name, "a name of labels.csv");
  return static_cast<std::size_t>(at - names.begin());
}

std::optional<double> ratio(std::int64_t part, std::int64_t whole) {
  if (whole == 0) return std::nullopt;
  return static_cast<double>(part) / static_cast<double>(whole);
}

}  // namespace

ClutterCounter::ClutterCounter()
    : by_object_(scene_object_names.size(), 0), by_cause_(event_cause_names.size(), 0) {}

void ClutterCounter::add(const LabelRow& label) {
  const std::size_t object = index_of(scene_object_names, label.object, "object");
  const std::size_t cause = index_of(event_cause_names, label.cause, "cause");
  ++events_;
  ++by_object_[object];
  ++by_cause_[cause];
  window_.push_back(object != 0);
  clutter_in_window_ += window_.back() ? 1 : 0;
  if (window_.size() > window_events) {
    clutter_in_window_ -= window_.front() ? 1 : 0;
    window_.pop_front();
  }
}

double ClutterCounter::share_in_window() const {
  if (window_.empty()) return std::numeric_limits<double>::quiet_NaN();
  return static_cast<double>(clutter_in_window_) / static_cast<double>(window_.size());
}

ClutterShare ClutterCounter::share() const {
  ClutterShare share;
  share.share = ratio(clutter_events(), events_);
  for (std::size_t i = 0; i < scene_object_names.size(); ++i) {
    share.by_object.emplace_back(scene_object_names[i], ratio(by_object_[i], events_));
  }
  for (std::size_t i = 0; i < event_cause_names.size(); ++i) {
    share.by_cause.emplace_back(event_cause_names[i], ratio(by_cause_[i], events_));
  }
  return share;
}

void ChanceClutter::add(double visible, double window_share, bool detected) {
  if (!(visible >= chance_visible_share) || !std::isfinite(window_share)) return;
  Mean& mean = detected ? detected_ : missed_;
  mean.sum += window_share;
  ++mean.count;
}

DetectorClutter ChanceClutter::result(std::int64_t clutter_events, std::int64_t inliers) const {
  const auto value = [](const Mean& mean) {
    return mean.count == 0 ? std::nullopt : std::optional(mean.sum / static_cast<double>(mean.count));
  };
  return {value(detected_), value(missed_), ratio(clutter_events, inliers)};
}

DetectorClutter detector_clutter(std::span<const TruthRow> truth, std::span<const double> window_share,
                                 std::span<const DetectionRow> detections, std::string_view detector,
                                 double threshold, std::int64_t clutter_events, std::int64_t inliers) {
  SACCADE_CHECK(truth.size() == window_share.size());
  ChanceClutter clutter;
  auto row = detections.begin();
  for (std::size_t i = 0; i < truth.size(); ++i) {
    bool has_one = false;
    for (; row != detections.end() && row->t_us <= truth[i].t_us; ++row) {
      has_one =
          has_one || (row->t_us == truth[i].t_us && row->detector == detector && row->score >= threshold);
    }
    clutter.add(truth[i].visible, window_share[i], has_one);
  }
  return clutter.result(clutter_events, inliers);
}

}  // namespace saccade
