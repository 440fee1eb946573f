#include "apps/view/recorded_detector.h"

#include <algorithm>
#include <utility>

#include "core/error.h"
#include "recording/run_file_names.h"
#include "recording/run_files.h"

namespace saccade {

std::map<std::string, std::shared_ptr<const RecordedEstimates>> read_estimates(
    const std::filesystem::path& folder) {
  std::map<std::string, std::shared_ptr<const RecordedEstimates>> estimates;
  const std::filesystem::path table = folder / run_file::detections;
  if (!std::filesystem::exists(table)) return estimates;
  std::map<std::string, std::shared_ptr<RecordedEstimates>> read;
  TableReader<DetectionRow> reader(table);
  while (const auto row = reader.next()) {
    std::shared_ptr<RecordedEstimates>& of_detector = read[row->detector];
    if (!of_detector) of_detector = std::make_shared<RecordedEstimates>();
    of_detector->push_back({row->t_us, row->circle, row->score, row->held});
  }
  for (auto& [name, of_detector] : read) estimates[name] = std::move(of_detector);
  return estimates;
}

RecordedDetector::RecordedDetector(std::shared_ptr<const RecordedEstimates> estimates,
                                   std::unique_ptr<Detector> detector, std::int64_t from_us)
    : estimates_(std::move(estimates)), detector_(std::move(detector)), from_us_(from_us) {
  SACCADE_CHECK(can_be_copied(*detector_));
}

void RecordedDetector::process(std::span<const Event> events, const CameraMotion* motion) {
  const auto first = std::ranges::lower_bound(events, from_us_, {}, &Event::t_us);
  if (first != events.end()) detector_->process({first, events.end()}, motion);
}

void RecordedDetector::advance_to(std::int64_t now_us, const CameraMotion* motion) {
  now_us_ = now_us;
  if (now_us >= from_us_) detector_->advance_to(now_us, motion);
}

Estimate RecordedDetector::estimate() {
  if (now_us_ >= from_us_) static_cast<void>(detector_->estimate());
  Estimate estimate;
  if (!estimates_) return estimate;
  const auto recorded = std::ranges::lower_bound(*estimates_, now_us_, {}, &RecordedEstimate::t_us);
  if (recorded == estimates_->end() || recorded->t_us != now_us_) return estimate;
  estimate.valid = true;
  estimate.held = recorded->held;
  estimate.circle = recorded->circle;
  estimate.score = recorded->score;
  return estimate;
}

std::unique_ptr<Detector> RecordedDetector::copy() const {
  auto copy = std::make_unique<RecordedDetector>(estimates_, copy_of(*detector_), from_us_);
  copy->now_us_ = now_us_;
  return copy;
}

}  // namespace saccade
