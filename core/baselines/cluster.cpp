#include "core/baselines/cluster.h"

#include <algorithm>
#include <cmath>

namespace saccade {
namespace {

constexpr double least_support = 0.5;  // of a cluster that lives: of one event, half a decay ago; chosen

}  // namespace

void describe(FieldVisitor& v, ClusterConfig& config) {
  describe_radius_px(v, config.radius_px);
  v.integer("clusters", config.clusters, {1, 1000}, "largest number of clusters");
  v.real("mixing", config.mixing, {1e-4, 1.0}, "weight of an event in the means of its cluster");
  v.real("surround", config.surround, {0.5, 10.0}, "reach of a cluster, in multiples of its radius");
  v.real("decay_us", config.decay_us, {100.0, 1e7}, "time constant of support");
  v.real("threshold", config.threshold, {0.0, 1e6}, "least support, in events, that is taken for the ball");
}

ClusterDetector::ClusterDetector(const ClusterConfig& config, ImageSize size)
    : config_(config), sieve_(size), now_us_(std::numeric_limits<std::int64_t>::min()) {
  check_config("detector", config);
  clusters_.reserve(static_cast<std::size_t>(config.clusters));
}

double ClusterDetector::support(const Cluster& cluster, std::int64_t now_us) const {
  const double age_us = static_cast<double>(now_us) - static_cast<double>(cluster.last_us);
  return cluster.support * std::exp(-age_us / config_.decay_us);
}

void ClusterDetector::add_support(Cluster& cluster, double more, std::int64_t now_us) const {
  cluster.support = support(cluster, now_us) + more;
  cluster.last_us = now_us;
  cluster.end_us = static_cast<double>(now_us) + config_.decay_us * std::log(cluster.support / least_support);
}

void ClusterDetector::remove(std::size_t index) {
  clusters_[index] = clusters_.back();
  clusters_.pop_back();
}

void ClusterDetector::seed(const Event& event) {
  if (std::ssize(clusters_) == config_.clusters) return;
  const double middle_px = (config_.radius_px[0] + config_.radius_px[1]) / 2;
  clusters_.push_back(
      {{static_cast<double>(event.x), static_cast<double>(event.y), middle_px}, 0.0, event.t_us});
  add_support(clusters_.back(), 1.0, event.t_us);
}

void ClusterDetector::merge(std::size_t index) {
  for (std::size_t i = clusters_.size(); i-- > 0;) {
    Cluster& kept = clusters_[index];
    const Cluster& other = clusters_[i];
    const double distance_px =
        std::hypot(other.circle.x_px - kept.circle.x_px, other.circle.y_px - kept.circle.y_px);
    if (i == index || distance_px >= kept.circle.r_px + other.circle.r_px) continue;
    const double gained = support(other, kept.last_us);
    const double weight = gained / (kept.support + gained);
    kept.circle.x_px += weight * (other.circle.x_px - kept.circle.x_px);
    kept.circle.y_px += weight * (other.circle.y_px - kept.circle.y_px);
    kept.circle.r_px += weight * (other.circle.r_px - kept.circle.r_px);
    add_support(kept, gained, kept.last_us);
    remove(i);
    if (index == clusters_.size()) index = i;  // the last one took the place of the removed one
  }
}

void ClusterDetector::take(const Event& event) {
  const auto has_ended = [&](const Cluster& c) { return c.end_us <= static_cast<double>(event.t_us); };
  for (std::size_t i = clusters_.size(); i-- > 0;) {
    if (has_ended(clusters_[i])) remove(i);
  }
  std::size_t nearest = clusters_.size();
  double nearest_px = 0.0;
  for (std::size_t i = 0; i < clusters_.size(); ++i) {
    const Circle& c = clusters_[i].circle;
    const double distance_px = std::hypot(event.x - c.x_px, event.y - c.y_px);
    if (distance_px > config_.surround * c.r_px) continue;
    if (nearest < clusters_.size() && distance_px >= nearest_px) continue;
    nearest = i;
    nearest_px = distance_px;
  }
  if (nearest == clusters_.size()) {
    seed(event);
    return;
  }
  Cluster& cluster = clusters_[nearest];
  Circle& c = cluster.circle;
  c.x_px += config_.mixing * (event.x - c.x_px);
  c.y_px += config_.mixing * (event.y - c.y_px);
  c.r_px =
      std::clamp(c.r_px + config_.mixing * (nearest_px - c.r_px), config_.radius_px[0], config_.radius_px[1]);
  add_support(cluster, 1.0, event.t_us);
  merge(nearest);
}

void ClusterDetector::process(std::span<const Event> events, const CameraMotion*) {
  for (const Event& event : events) {
    if (!sieve_.accept(event)) continue;
    now_us_ = std::max(now_us_, event.t_us);
    take(event);
  }
}

void ClusterDetector::advance_to(std::int64_t now_us, const CameraMotion*) {
  now_us_ = std::max(now_us_, now_us);
}

Estimate ClusterDetector::estimate() {
  Estimate best;
  for (const Cluster& cluster : clusters_) {
    const double score = support(cluster, now_us_);
    if (score > std::max(least_support, best.score)) best = {true, false, cluster.circle, score};
  }
  return best;
}

}  // namespace saccade
