#include "apps/sweep/processor_time.h"

#include <algorithm>
#include <ctime>

namespace saccade {
namespace {

/// Of this thread, ns.
std::int64_t processor_ns() {
  timespec now{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

/// Adds the time until its end to a sum.
class Span {
 public:
  explicit Span(std::int64_t& sum_ns) : sum_ns_(sum_ns), begin_ns_(processor_ns()) {}
  Span(const Span&) = delete;
  Span& operator=(const Span&) = delete;
  ~Span() { sum_ns_ += processor_ns() - begin_ns_; }

 private:
  std::int64_t& sum_ns_;
  std::int64_t begin_ns_;
};

class MeasuredDetector final : public Detector {
 public:
  MeasuredDetector(std::unique_ptr<Detector> detector, std::int64_t& ns)
      : detector_(std::move(detector)), ns_(ns) {}

  void process(std::span<const Event> events, const CameraMotion* motion) override {
    const Span span(ns_);
    detector_->process(events, motion);
  }
  void advance_to(std::int64_t now_us, const CameraMotion* motion) override {
    const Span span(ns_);
    detector_->advance_to(now_us, motion);
  }
  [[nodiscard]] Estimate estimate() override {
    const Span span(ns_);
    return detector_->estimate();
  }
  void work_ahead() override {
    const Span span(ns_);
    detector_->work_ahead();
  }
  [[nodiscard]] double threshold() const override { return detector_->threshold(); }
  [[nodiscard]] RejectedEvents rejected() const override { return detector_->rejected(); }
  [[nodiscard]] std::string_view failure() const override { return detector_->failure(); }

 private:
  std::unique_ptr<Detector> detector_;
  std::int64_t& ns_;
};

bool in_other_program(const DetectorConfig& config) {
  const std::string& preset = config.preset();
  return preset == "python" || preset == "command" || preset == "socket";
}

}  // namespace

void ProcessorTimes::measure(const Scenario& scenario, std::vector<LoopDetector>& detectors) {
  for (LoopDetector& detector : detectors) {
    const auto named =
        std::ranges::find(scenario.detectors, detector.name, [](const auto& one) { return one.first; });
    if (named == scenario.detectors.end() || in_other_program(named->second)) continue;
    Time& time = *times_.emplace_back(std::make_unique<Time>(Time{detector.name}));
    detector.detector = std::make_unique<MeasuredDetector>(std::move(detector.detector), time.ns);
  }
}

void ProcessorTimes::replace_costs(Metrics& metrics) const {
  const std::int64_t events = metrics.event_count - (metrics.right_eye ? metrics.right_eye->event_count : 0);
  if (events == 0) return;
  for (auto& [name, score] : metrics.detectors) {
    const auto time =
        std::ranges::find(times_, name, [](const auto& one) -> const std::string& { return one->detector; });
    if (time != times_.end())
      score.us_per_event = static_cast<double>((*time)->ns) * 1e-3 / static_cast<double>(events);
  }
}

}  // namespace saccade
