#include "core/baselines/blob_filter.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/time_stamp.h"

namespace saccade {
namespace {

constexpr double least_support = 0.5;  // of a blob that lives: of one event, half a decay ago; chosen
constexpr double first_velocity_variance = 800.0;  // (px/s)^2; a blob begins at about 28 px/s; chosen
constexpr double radius_per_deviation = std::numbers::sqrt2;  // of points on a circle in each coordinate

}  // namespace

void describe(FieldVisitor& v, BlobFilterConfig& config) {
  describe_radius_px(v, config.radius_px);
  v.integer("blobs", config.blobs, {1, 100}, "most at a time");
  v.real("reach", config.reach, {0.5, 10.0}, "of a blob, in standard deviations");
  v.real("least_reach_px", config.least_reach_px, {0.0, 1000.0}, "of a blob, at least");
  v.real("position_noise_px2_s", config.position_noise_px2_s, {0.0, 1e9},
         "growth of the variance of a centre");
  v.real("velocity_noise_px2_s3", config.velocity_noise_px2_s3, {0.0, 1e12},
         "growth of the variance of a velocity");
  v.real("size_noise_px2_s", config.size_noise_px2_s, {0.0, 1e6},
         "growth of the variance of a standard deviation");
  v.real("decay_us", config.decay_us, {100.0, 1e7}, "time constant of support");
  v.real("threshold", config.threshold, {0.0, 1e6}, "events per px of outline taken for the ball");
}

BlobFilter::BlobFilter(const BlobFilterConfig& config, ImageSize size)
    : config_(config), sieve_(size), now_us_(std::numeric_limits<std::int64_t>::min()) {
  check_config("detector", config);
  blobs_.reserve(static_cast<std::size_t>(config.blobs));
}

double BlobFilter::support(const Blob& blob, std::int64_t now_us) const {
  const auto age_us = static_cast<double>(saturated_difference(now_us, blob.last_us));
  return blob.support * std::exp(-age_us / config_.decay_us);
}

double BlobFilter::reach_px(const Blob& blob) const {
  return std::max(config_.least_reach_px, config_.reach * blob.deviation_px());
}

void BlobFilter::start(const Event& event) {
  if (std::ssize(blobs_) == config_.blobs) return;
  const auto& [least_px, most_px] = config_.radius_px;
  const double middle_px = (least_px + most_px) / 2;
  const double range_px = (most_px - least_px) / radius_per_deviation;
  Blob blob;
  blob.state << event.x, event.y, 0.0, 0.0, middle_px / radius_per_deviation;
  blob.covariance.diagonal() << middle_px * middle_px, middle_px * middle_px, first_velocity_variance,
      first_velocity_variance, range_px * range_px / 16;
  blob.support = 1.0;
  blob.last_us = event.t_us;
  blobs_.push_back(blob);
}

void BlobFilter::predict(Blob& blob, std::int64_t t_us) const {
  const double dt_s = static_cast<double>(saturated_difference(t_us, blob.last_us)) * 1e-6;
  Eigen::Matrix<double, 5, 5> transition = Eigen::Matrix<double, 5, 5>::Identity();
  transition(0, 2) = transition(1, 3) = dt_s;
  blob.state.head<2>() += dt_s * blob.state.segment<2>(2);
  blob.covariance = (transition * blob.covariance * transition.transpose()).eval();
  State noise;
  noise << config_.position_noise_px2_s, config_.position_noise_px2_s, config_.velocity_noise_px2_s3,
      config_.velocity_noise_px2_s3, config_.size_noise_px2_s;
  blob.covariance.diagonal() += dt_s * noise;
}

/// The three measurements of an event, linearised at the same state, one after the other.
void BlobFilter::update(Blob& blob, const Event& event) const {
  const State before = blob.state;
  const double s = blob.deviation_px();
  const Eigen::Vector2d off_px = Eigen::Vector2d(event.x, event.y) - before.head<2>();
  const auto measure = [&](const State& gradient, double difference, double variance) {
    const State gain = blob.covariance * gradient;
    const double innovation = difference - gradient.dot(blob.state - before);
    const double total = gradient.dot(gain) + variance;
    blob.state += gain * (innovation / total);
    blob.covariance -= (gain * (gain.transpose() / total)).eval();
  };
  for (int axis = 0; axis < 2; ++axis) {
    State gradient = State::Zero();
    gradient[axis] = -1.0 / s;
    gradient[4] = -off_px[axis] / (s * s);
    measure(gradient, -off_px[axis] / s, 1.0);
  }
  const auto n = static_cast<double>(std::min(blob.events, history));
  if (n > 0.0) {
    double sum_px2 = 0.0;
    for (const double distance2_px2 : blob.distance2_px2) sum_px2 += distance2_px2;
    State gradient = State::Zero();
    gradient[4] = -2.0 * sum_px2 / (s * s * s);
    measure(gradient, 2.0 * n - sum_px2 / (s * s), 4.0 * n);
  }
  blob.distance2_px2[blob.events % history] = off_px.squaredNorm();
  ++blob.events;
  double& deviation_px = blob.state[4];
  deviation_px = std::clamp(deviation_px, config_.radius_px[0] / radius_per_deviation,
                            config_.radius_px[1] / radius_per_deviation);
}

/// Of two blobs one in the other the one with more support stays.
void BlobFilter::remove_rivals(std::size_t index) {
  for (std::size_t i = blobs_.size(); i-- > 0;) {
    const Blob& blob = blobs_[index];
    const Blob& other = blobs_[i];
    if (i == index || (other.state - blob.state).head<2>().norm() >= blob.deviation_px()) continue;
    const bool stays = support(blob, now_us_) >= support(other, now_us_);
    blobs_.erase(blobs_.begin() + static_cast<std::ptrdiff_t>(stays ? i : index));
    if (!stays) return;
    if (i < index) --index;
  }
}

void BlobFilter::take(const Event& event) {
  std::erase_if(blobs_, [&](const Blob& blob) { return support(blob, event.t_us) < least_support; });
  std::size_t nearest = blobs_.size();
  double nearest_px = 0.0;
  for (std::size_t i = 0; i < blobs_.size(); ++i) {
    const double distance_px = (blobs_[i].state.head<2>() - Eigen::Vector2d(event.x, event.y)).norm();
    if (distance_px > reach_px(blobs_[i])) continue;
    if (nearest < blobs_.size() && distance_px >= nearest_px) continue;
    nearest = i;
    nearest_px = distance_px;
  }
  if (nearest == blobs_.size()) {
    start(event);
    return;
  }
  Blob& blob = blobs_[nearest];
  blob.support = support(blob, event.t_us) + 1.0;
  predict(blob, event.t_us);
  blob.last_us = event.t_us;
  update(blob, event);
  remove_rivals(nearest);
}

void BlobFilter::process(std::span<const Event> events, const CameraMotion*) {
  for (const Event& event : events) {
    if (!sieve_.accept(event)) continue;
    now_us_ = std::max(now_us_, event.t_us);
    take(event);
  }
}

void BlobFilter::advance_to(std::int64_t now_us, const CameraMotion*) { now_us_ = std::max(now_us_, now_us); }

Estimate BlobFilter::estimate() {
  Estimate best;
  for (const Blob& blob : blobs_) {
    const double left = support(blob, now_us_);
    const double r_px = radius_per_deviation * blob.deviation_px();
    const double score = left / (2.0 * std::numbers::pi * r_px);
    if (left < least_support || score <= best.score) continue;
    best = {true, false, {blob.state[0], blob.state[1], r_px}, score};
    best.covariance_px2.topLeftCorner<2, 2>() = blob.covariance.topLeftCorner<2, 2>();
    best.covariance_px2.topRightCorner<2, 1>() =
        radius_per_deviation * blob.covariance.topRightCorner<2, 1>();
    best.covariance_px2.bottomLeftCorner<1, 2>() =
        radius_per_deviation * blob.covariance.bottomLeftCorner<1, 2>();
    best.covariance_px2(2, 2) = radius_per_deviation * radius_per_deviation * blob.covariance(4, 4);
  }
  return best;
}

}  // namespace saccade
