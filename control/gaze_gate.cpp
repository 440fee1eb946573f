#include "control/gaze_gate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace saccade {
namespace {

bool detected(const Estimate& e, double threshold) { return e.valid && e.score >= threshold; }

class CountingGate : public GazeGate {
 public:
  explicit CountingGate(const TargetConfig& config) : locator_(config) {}
  [[nodiscard]] RejectedTargets rejected() const override { return rejected_; }

 protected:
  std::optional<Eigen::Vector3d> locate(const Circle& circle, const PinholeCamera& camera,
                                        const Eigen::Isometry3d& root_from_cam) {
    const Target target = locator_.locate(circle, camera, root_from_cam);
    if (target.status == TargetStatus::ok) return target.point_m;
    count(target.status);
    return std::nullopt;
  }
  void count(TargetStatus status) {
    rejected_.not_finite += status == TargetStatus::not_finite;
    rejected_.bad_radius += status == TargetStatus::bad_radius;
    rejected_.too_near += status == TargetStatus::too_near;
    rejected_.behind += status == TargetStatus::behind;
  }

 private:
  TargetLocator locator_;
  RejectedTargets rejected_;
};

class OpenGate final : public CountingGate {
 public:
  using CountingGate::CountingGate;

  std::optional<Eigen::Vector3d> update(std::int64_t, const Estimate& estimate, double threshold,
                                        const PinholeCamera& camera,
                                        const Eigen::Isometry3d& root_from_cam) override {
    if (!detected(estimate, threshold)) return std::nullopt;
    return locate(estimate.circle, camera, root_from_cam);
  }
};

class AuthorsGate final : public CountingGate {
 public:
  AuthorsGate(const AuthorsGateConfig& config, const TargetConfig& target)
      : CountingGate(target), config_(config), window_us_(std::llround(config.window_s * 1e6)) {}

  std::optional<Eigen::Vector3d> update(std::int64_t now_us, const Estimate& estimate, double threshold,
                                        const PinholeCamera& camera,
                                        const Eigen::Isometry3d& root_from_cam) override {
    while (size_ > 0 && now_us - at(0).t_us >= window_us_) drop_oldest();
    if (!detected(estimate, threshold) || estimate.held) return std::nullopt;
    const Circle& c = estimate.circle;
    if (!std::isfinite(c.x_px) || !std::isfinite(c.y_px) || !std::isfinite(c.r_px)) {
      count(TargetStatus::not_finite);
      return std::nullopt;
    }
    if (size_ == capacity) drop_oldest();
    ring_[(first_ + size_++) % capacity] = {now_us, c};
    if (size_ < static_cast<std::size_t>(config_.min_detections)) return std::nullopt;

    const Spread x = spread(&Circle::x_px);
    const Spread y = spread(&Circle::y_px);
    if (!(x.deviation < config_.max_spread_px) || !(y.deviation < config_.max_spread_px)) return std::nullopt;
    if (std::abs(c.x_px - x.median) > x.deviation || std::abs(c.y_px - y.median) > y.deviation) {
      return std::nullopt;
    }
    double r_px = 0.0;
    for (std::size_t i = 0; i < size_; ++i) r_px = std::max(r_px, at(i).circle.r_px);
    std::optional<Eigen::Vector3d> target =
        locate({x.median, y.median, std::min(r_px, config_.max_radius_px)}, camera, root_from_cam);
    if (target) target->x() = std::min(target->x(), config_.max_target_x_m);
    return target;
  }

 private:
  struct Detection {
    std::int64_t t_us = 0;
    Circle circle;
  };
  struct Spread {
    double median;
    double deviation;
  };
  static constexpr std::size_t capacity = 2048;  // the longest window at one detection per ms

  [[nodiscard]] const Detection& at(std::size_t i) const { return ring_[(first_ + i) % capacity]; }
  void drop_oldest() {
    first_ = (first_ + 1) % capacity;
    --size_;
  }
  /// Upper median and standard deviation of one coordinate over the window.
  Spread spread(double Circle::*coordinate) {
    double sum = 0.0;
    for (std::size_t i = 0; i < size_; ++i) sum += sorted_[i] = at(i).circle.*coordinate;
    const double mean = sum / static_cast<double>(size_);
    double squares = 0.0;
    for (const double value : std::span(sorted_).first(size_)) squares += (value - mean) * (value - mean);
    const auto middle = sorted_.begin() + static_cast<std::ptrdiff_t>(size_ / 2);
    std::nth_element(sorted_.begin(), middle, sorted_.begin() + static_cast<std::ptrdiff_t>(size_));
    return {*middle, std::sqrt(squares / static_cast<double>(size_))};
  }

  AuthorsGateConfig config_;
  std::int64_t window_us_;
  std::array<Detection, capacity> ring_{};
  std::size_t first_ = 0;
  std::size_t size_ = 0;
  std::array<double, capacity> sorted_{};
};

}  // namespace

void describe(FieldVisitor& v, GateConfig& config) {
  v.choice("gate", config.gate, {"none", "authors"}, "which detections become gaze targets");
  v.section(
      "authors_gate",
      [&](FieldVisitor& w) {
        w.real("window_s", config.authors.window_s, {0.01, 2.0}, "how far back detections count");
        w.integer("min_detections", config.authors.min_detections, {1, 2000}, "that many in the window");
        w.real("max_spread_px", config.authors.max_spread_px, {0.1, 1e3},
               "their standard deviation stays below");
        w.real("max_radius_px", config.authors.max_radius_px, {1.0, 1e3},
               "where the largest radius is clipped");
        w.real("max_target_x_m", config.authors.max_target_x_m, {-10.0, 0.0},
               "targets stay this far in front");
      },
      "the authors' gate");
  v.section(
      "target", [&](FieldVisitor& w) { describe(w, config.target); }, "from a circle to a point");
}

std::unique_ptr<GazeGate> make_gate(const GateConfig& config) {
  check_config("gaze", config);
  if (config.gate == "none") return std::make_unique<OpenGate>(config.target);
  return std::make_unique<AuthorsGate>(config.authors, config.target);
}

}  // namespace saccade
