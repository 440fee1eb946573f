#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "recording/run_files.h"

namespace saccade {

/// Shares of a run's events by object and by cause, from their labels. None = there are no events.
struct ClutterShare {
  std::optional<double> share;  ///< of the events that the ball did not make
  /// Shares of all events, in the order of docs/columns.md; they sum up to 1.
  std::vector<std::pair<std::string, std::optional<double>>> by_object;
  std::vector<std::pair<std::string, std::optional<double>>> by_cause;
};

/// The clutter at a detector's chances.
struct DetectorClutter {
  /// Mean share of clutter (events that the ball did not make) among the newest ClutterCounter::window_events events, over the chances at which the
  /// detector had an observation at or above its threshold, and over those at which it had none.
  std::optional<double> in_window_detected;
  std::optional<double> in_window_missed;
  std::optional<double> per_detection;  ///< events of the run that the ball did not make, per inlier
};

/// Counts labelled events one by one, in fixed memory.
class ClutterCounter {
 public:
  static constexpr std::size_t window_events = 1500;  ///< as many as the paper's window holds

  ClutterCounter();
  /// Throws InputError for an unknown cause or object.
  void add(const LabelRow& label);
  /// The share of clutter among the newest window_events events; NaN before the first one.
  [[nodiscard]] double share_in_window() const;
  [[nodiscard]] ClutterShare share() const;
  [[nodiscard]] std::int64_t clutter_events() const { return events_ - by_object_[0]; }

 private:
  std::int64_t events_ = 0;
  std::vector<std::int64_t> by_object_;
  std::vector<std::int64_t> by_cause_;
  std::deque<bool> window_;  // true for clutter
  std::size_t clutter_in_window_ = 0;
};

/// Averages the clutter at one detector's chances, instant by instant, in fixed memory.
class ChanceClutter {
 public:
  /// `visible` of the instant's truth; `window_share`: ClutterCounter::share_in_window(); `detected`: whether the
  /// detector has an observation at or above its threshold.
  void add(double visible, double window_share, bool detected);
  /// `clutter_events`: ClutterCounter::clutter_events(). `inliers`: DetectorScore::inliers.
  [[nodiscard]] DetectorClutter result(std::int64_t clutter_events, std::int64_t inliers) const;

 private:
  struct Mean {
    double sum = 0.0;
    std::int64_t count = 0;
  };
  Mean detected_;
  Mean missed_;
};

/// The same from vectors. `window_share`: share_in_window() at each row of simulated truth. `inliers`: DetectorScore::inliers.
[[nodiscard]] DetectorClutter detector_clutter(std::span<const TruthRow> truth,
                                               std::span<const double> window_share,
                                               std::span<const DetectionRow> detections,
                                               std::string_view detector, double threshold,
                                               std::int64_t clutter_events, std::int64_t inliers);

}  // namespace saccade
