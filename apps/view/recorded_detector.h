#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/detector_views.h"

namespace saccade {

/// An estimate of a detector in a run's detections.csv.
struct RecordedEstimate {
  std::int64_t t_us = 0;
  Circle circle;
  double score = 0.0;
  bool held = false;
};
using RecordedEstimates = std::vector<RecordedEstimate>;  // sorted by time

/// The estimates in detections.csv of a run folder by detector; empty where there is none. Throws InputError for a broken table.
[[nodiscard]] std::map<std::string, std::shared_ptr<const RecordedEstimates>> read_estimates(
    const std::filesystem::path& folder);

/// A detector of a finished run: its estimates are those that the run recorded. The detector itself gets the events from
/// `from_us` on, for its Hough space alone.
class RecordedDetector final : public Detector, public DetectorViews {
 public:
  /// `estimates`: null where the run recorded none. `detector` can be copied (can_be_copied()).
  RecordedDetector(std::shared_ptr<const RecordedEstimates> estimates, std::unique_ptr<Detector> detector,
                   std::int64_t from_us);

  void process(std::span<const Event> events, const CameraMotion* motion) override;
  void advance_to(std::int64_t now_us, const CameraMotion* motion) override;
  [[nodiscard]] Estimate estimate() override;
  [[nodiscard]] double threshold() const override { return detector_->threshold(); }
  [[nodiscard]] RejectedEvents rejected() const override { return detector_->rejected(); }

  [[nodiscard]] bool hough_space(std::span<float> response) const override {
    return hough_space_of(*detector_, response);
  }
  [[nodiscard]] std::unique_ptr<Detector> copy() const override;

 private:
  std::shared_ptr<const RecordedEstimates> estimates_;
  std::unique_ptr<Detector> detector_;
  std::int64_t from_us_;
  std::int64_t now_us_ = 0;
};

}  // namespace saccade
