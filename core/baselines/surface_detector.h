#pragma once

#include <cstdint>
#include <optional>

#include "core/baselines/kernel_search.h"
#include "core/detector_parts.h"
#include "core/detector_views.h"

namespace saccade {

/// What the detectors on a surface of recent events have in common: at every whole millisecond of the stream's time a
/// step of KernelSearch, whatever the rate of events.
class SurfaceDetectorBase : public Detector, public DetectorViews {
 public:
  void process(std::span<const Event> events, const CameraMotion*) final;
  void advance_to(std::int64_t now_us, const CameraMotion*) final { run_until(now_us, true); }
  /// Held where no event came in the last millisecond: the surface does not change with time alone.
  [[nodiscard]] Estimate estimate() final;
  [[nodiscard]] RejectedEvents rejected() const final { return sieve_.rejected(); }

 protected:
  SurfaceDetectorBase(const std::array<double, 2>& radius_px, ImageSize size)
      : sieve_(size), search_(radius_px, size) {}

 private:
  virtual void add(const Event& event) = 0;
  [[nodiscard]] virtual std::span<const double> surface() const = 0;
  void run_until(std::int64_t t_us, bool inclusive);

  EventSieve sieve_;
  KernelSearch search_;
  std::optional<std::int64_t> next_step_us_;  // no step before the first event
  std::int64_t newest_us_ = std::numeric_limits<std::int64_t>::min();
  std::int64_t steps_without_events_ = 0;
};

/// A detector on `Surface`, which has `Surface(const Config&, ImageSize)`, `add(const Event&)` and `values()`: a value in
/// [0, 255] for each pixel, row by row. `Config` has radius_px and threshold.
template <class Config, class Surface>
class SurfaceDetector final : public SurfaceDetectorBase {
 public:
  /// Throws InputError for a configuration out of range.
  SurfaceDetector(const Config& config, ImageSize size)
      : SurfaceDetectorBase(checked(config).radius_px, size), config_(config), surface_(config, size) {}

  [[nodiscard]] double threshold() const override { return config_.threshold; }
  [[nodiscard]] std::unique_ptr<Detector> copy() const override {
    return std::make_unique<SurfaceDetector>(*this);
  }

 private:
  static const Config& checked(const Config& config) {
    check_config("detector", config);
    return config;
  }
  void add(const Event& event) override { surface_.add(event); }
  [[nodiscard]] std::span<const double> surface() const override { return surface_.values(); }

  Config config_;
  Surface surface_;
};

}  // namespace saccade
