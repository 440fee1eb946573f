#include "control/gaze_gate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <span>

namespace saccade {
namespace {

bool detected(const Estimate& e, double threshold) { return e.valid && e.score >= threshold; }

class CountingGate : public GazeGate {
 public:
  explicit CountingGate(const TargetConfig& config) : locator_(config) {}
  [[nodiscard]] RejectedTargets rejected() const override { return rejected_; }

 protected:
  std::optional<Eigen::Vector3d> locate(const Circle& circle, const Camera& camera,
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
                                        const Camera& camera,
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
                                        const Camera& camera,
                                        const Eigen::Isometry3d& root_from_cam) override {
    while (size_ > 0 && now_us - at(0).t_us >= window_us_) drop_oldest();
    if (!detected(estimate, threshold) || estimate.held) return std::nullopt;
    const Circle& c = estimate.circle;
    if (!std::isfinite(c.x_px) || !std::isfinite(c.y_px) || !std::isfinite(c.r_px)) {
      count(TargetStatus::not_finite);
      return std::nullopt;
    }
    const Eigen::Vector3d ray = camera.ray(c.x_px, c.y_px);
    if (!ray.allFinite()) {
      count(TargetStatus::not_finite);
      return std::nullopt;
    }
    if (size_ == capacity) drop_oldest();
    ring_[(first_ + size_++) % capacity] = {now_us, root_from_cam.linear() * ray, c.r_px};
    if (size_ < static_cast<std::size_t>(config_.min_detections)) return std::nullopt;

    const Eigen::Matrix3d cam_from_root = root_from_cam.linear().transpose();
    double r_px = 0.0;
    std::size_t seen = 0;
    for (std::size_t i = 0; i < size_; ++i) {
      const auto at_px = camera.project(cam_from_root * at(i).ray);
      if (!at_px) continue;
      x_px_[seen] = at_px->x();
      y_px_[seen++] = at_px->y();
      r_px = std::max(r_px, at(i).r_px);
    }
    if (seen < static_cast<std::size_t>(config_.min_detections)) return std::nullopt;
    const Spread x = spread(std::span(x_px_).first(seen));
    const Spread y = spread(std::span(y_px_).first(seen));
    if (!(x.deviation < config_.max_spread_px) || !(y.deviation < config_.max_spread_px)) return std::nullopt;
    if (std::abs(c.x_px - x.median) > x.deviation || std::abs(c.y_px - y.median) > y.deviation) {
      return std::nullopt;
    }
    std::optional<Eigen::Vector3d> target =
        locate({x.median, y.median, std::min(r_px, config_.max_radius_px)}, camera, root_from_cam);
    if (target) target->x() = std::min(target->x(), config_.max_target_x_m);
    return target;
  }

 private:
  struct Detection {
    std::int64_t t_us = 0;
    Eigen::Vector3d ray = Eigen::Vector3d::Zero();  ///< root frame, through its centre
    double r_px = 0.0;
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
  /// Upper median and standard deviation; leaves the values in another order.
  static Spread spread(std::span<double> values) {
    const auto count = static_cast<double>(values.size());
    const double mean = std::accumulate(values.begin(), values.end(), 0.0) / count;
    double squares = 0.0;
    for (const double value : values) squares += (value - mean) * (value - mean);
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::ranges::nth_element(values, middle);
    return {*middle, std::sqrt(squares / count)};
  }

  AuthorsGateConfig config_;
  std::int64_t window_us_;
  std::array<Detection, capacity> ring_{};
  std::size_t first_ = 0;
  std::size_t size_ = 0;
  std::array<double, capacity> x_px_{}, y_px_{};  // where the image of now shows them
};

class ContinuityGate final : public CountingGate {
 public:
  ContinuityGate(const ContinuityGateConfig& config, const TargetConfig& target)
      : CountingGate(target),
        config_(config),
        window_us_(std::llround(config.window_s * 1e6)),
        forget_us_(std::llround(config.forget_s * 1e6)) {}

  std::optional<Eigen::Vector3d> update(std::int64_t now_us, const Estimate& estimate, double threshold,
                                        const Camera& camera,
                                        const Eigen::Isometry3d& root_from_cam) override {
    if (!detected(estimate, threshold)) return std::nullopt;
    const auto point_m = locate(estimate.circle, camera, root_from_cam);
    if (!point_m) return std::nullopt;
    const Eigen::Vector3d eye_m = root_from_cam.translation();
    const Place here{now_us, *point_m};
    recent_[count_++ % capacity] = here;

    if (last_ && now_us - last_->t_us <= forget_us_) {
      const double unseen_s = static_cast<double>(now_us - last_->t_us) * 1e-6;
      const double tolerance_deg = config_.tolerance_deg + config_.growth_deg_s * unseen_s;
      if (!agree(here.point_m, last_->point_m, eye_m, tolerance_deg)) return std::nullopt;
    } else if (!confirmed(here, eye_m)) {
      return std::nullopt;
    }
    last_ = here;
    return point_m;
  }

 private:
  struct Place {
    std::int64_t t_us = 0;
    Eigen::Vector3d point_m = Eigen::Vector3d::Zero();
  };
  static constexpr std::size_t capacity = 1024;  // the longest window at one detection per ms

  [[nodiscard]] bool confirmed(const Place& here, const Eigen::Vector3d& eye_m) const {
    std::int64_t agreeing = 0;
    for (std::size_t back = 1; back <= std::min(count_, capacity); ++back) {
      const Place& other = recent_[(count_ - back) % capacity];
      if (here.t_us - other.t_us > window_us_) break;
      agreeing += agree(here.point_m, other.point_m, eye_m, config_.tolerance_deg);
    }
    return agreeing >= config_.min_agreeing;
  }
  [[nodiscard]] bool agree(const Eigen::Vector3d& a_m, const Eigen::Vector3d& b_m,
                           const Eigen::Vector3d& eye_m, double tolerance_deg) const {
    const Eigen::Vector3d a = a_m - eye_m;
    const Eigen::Vector3d b = b_m - eye_m;
    const double angle_rad = std::atan2(a.cross(b).norm(), a.dot(b));
    const double ratio = a.norm() / b.norm();
    return angle_rad * 180.0 / std::numbers::pi <= tolerance_deg && ratio <= config_.depth_ratio &&
           ratio * config_.depth_ratio >= 1.0;
  }

  ContinuityGateConfig config_;
  std::int64_t window_us_;
  std::int64_t forget_us_;
  std::array<Place, capacity> recent_{};
  std::size_t count_ = 0;
  std::optional<Place> last_;
};

}  // namespace

void describe(FieldVisitor& v, GateConfig& config) {
  v.choice("gate", config.gate, {"none", "authors", "continuity"}, "which detections become gaze targets");
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
      "continuity_gate",
      [&](FieldVisitor& w) {
        ContinuityGateConfig& c = config.continuity;
        w.real("tolerance_deg", c.tolerance_deg, {0.01, 180.0}, "detections this close in bearing agree");
        w.real("depth_ratio", c.depth_ratio, {1.0, 100.0},
               "if their distances differ by less than this factor");
        w.real("growth_deg_s", c.growth_deg_s, {0.0, 1e4}, "the tolerance grows by this while none came");
        w.real("window_s", c.window_s, {0.001, 1.0}, "how far back a confirmation may lie");
        w.integer("min_agreeing", c.min_agreeing, {1, 1000}, "detections that confirm a new place");
        w.real("forget_s", c.forget_s, {0.001, 60.0}, "after so long the last place does not count any more");
      },
      "a ball does not jump");
  v.section(
      "target", [&](FieldVisitor& w) { describe(w, config.target); }, "from a circle to a point");
}

std::unique_ptr<GazeGate> make_gate(const GateConfig& config) {
  check_config("gaze", config);
  if (config.gate == "none") return std::make_unique<OpenGate>(config.target);
  if (config.gate == "authors") return std::make_unique<AuthorsGate>(config.authors, config.target);
  return std::make_unique<ContinuityGate>(config.continuity, config.target);
}

}  // namespace saccade
