#include "core/baselines/particle_filter.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace saccade {
namespace {

constexpr double region_px = 10.0;                  // of interest, beyond the radius; chosen
constexpr std::size_t ring_size = 4096,             // events: more than most_events
    most_events = 3000,                             // of the window of a tracked ball: bounds the work
    search_events = 1000;                           // of the window while no ball is tracked
constexpr double least_events = 50.0,               // of the window of a tracked ball
    window_slack = 30.0;                            // events that a window may be too long before it is cut
constexpr double radius_motion_share = 0.2;         // of a particle's motion per update; chosen
constexpr std::uint64_t numbers_per_particle = 64,  // random numbers of a particle and update, at most
    resample_numbers = 32;                          // from here on those of resampling
constexpr std::uint64_t tries = 8;                  // of a start for a particle before it is left where it is

/// The circle through three points; of radius 0 where they are on a line.
Circle circle_through(const std::array<double, 2>& a, const std::array<double, 2>& b,
                      const std::array<double, 2>& c) {
  const double bx = b[0] - a[0], by = b[1] - a[1];
  const double cx = c[0] - a[0], cy = c[1] - a[1];
  const double twice_area = bx * cy - by * cx;
  if (std::abs(twice_area) < 1e-9) return {};
  const double b2 = bx * bx + by * by;
  const double c2 = cx * cx + cy * cy;
  const double x = (cy * b2 - by * c2) / (2.0 * twice_area);
  const double y = (bx * c2 - cx * b2) / (2.0 * twice_area);
  return {a[0] + x, a[1] + y, std::hypot(x, y)};
}

}  // namespace

void describe(FieldVisitor& v, ParticleFilterConfig& config) {
  describe_radius_px(v, config.radius_px);
  v.integer("particles", config.particles, {1, 1000}, "circles that the filter is made of");
  v.integer("bins", config.bins, {8, 1024}, "of the angle around a particle");
  v.real("min_likelihood", config.min_likelihood, {1e-3, 1.0}, "of a particle, share of the bins");
  v.real("inlier_px", config.inlier_px, {0.1, 10.0}, "distance from 1 px on in which an event counts less");
  v.real("negative_bias", config.negative_bias, {0.0, 100.0}, "of the events inside a particle");
  v.real("motion_px", config.motion_px, {0.0, 20.0}, "of a particle in an update, at most");
  v.real("threshold", config.threshold, {0.0, 1.0}, "share of the bins taken for the ball");
  v.integer("lost_updates", config.lost_updates, {1, 1000}, "updates below the threshold that end a track");
  v.integer("seed", config.seed, {0, 1e9}, "of the random numbers");
}

ParticleFilter::ParticleFilter(const ParticleFilterConfig& config, ImageSize size)
    : config_(check_config("detector", config)),
      size_(size),
      sieve_(size),
      random_(static_cast<std::uint64_t>(config.seed), "particle_filter"),
      particles_(static_cast<std::size_t>(config.particles)),
      parents_(particles_.size()),
      covered_(static_cast<std::size_t>(config.bins)),
      table_px_(static_cast<int>(std::ceil(config.radius_px[1] + config.inlier_px)) + 2),
      window_(ring_size) {
  for (int y = -table_px_; y <= table_px_; ++y) {
    for (int x = -table_px_; x <= table_px_; ++x) {
      const double turn = (std::atan2(y, x) + std::numbers::pi) / (2.0 * std::numbers::pi);
      polar_.push_back({static_cast<float>(std::hypot(x, y)),
                        static_cast<std::uint16_t>(turn * static_cast<double>(config.bins - 1) + 0.5)});
    }
  }
}

/// A random number of this update. `which` < numbers_per_particle.
double ParticleFilter::uniform(std::size_t particle, std::uint64_t which, double low, double high) const {
  return random_.uniform(low, high, particle * numbers_per_particle + which, updates_);
}

void ParticleFilter::process(std::span<const Event> events, const CameraMotion*) {
  for (const Event& event : events) {
    if (sieve_.accept(event)) add(event);
  }
}

void ParticleFilter::add(const Event& event) {
  const Circle& c = estimate_.circle;
  const double half_px = c.r_px + region_px;
  if (tracking_ && (std::abs(event.x - c.x_px) > half_px || std::abs(event.y - c.y_px) > half_px)) return;
  window_[end_] = {event.x, event.y};
  end_ = (end_ + 1) % window_.size();
  count_ = std::min(count_ + 1, tracking_ ? window_.size() : search_events);
  ++added_;
  const double r_px = tracking_ ? c.r_px : (config_.radius_px[0] + config_.radius_px[1]) / 2;
  if (added_ < std::numbers::pi * r_px) return;
  added_ = 0.0;
  update();
}

void ParticleFilter::update() {
  ++updates_;
  if (!tracking_) search();
  double total = 0.0;
  for (Particle& p : particles_) {
    observe(p);
    total += p.weight;
  }
  Circle mean;
  double window = 0.0;
  const Particle* best = &particles_[0];
  for (Particle& p : particles_) {
    p.weight /= total;
    mean.x_px += p.weight * p.circle.x_px;
    mean.y_px += p.weight * p.circle.y_px;
    mean.r_px += p.weight * p.circle.r_px;
    window += p.weight * p.window;
    if (p.likelihood > best->likelihood) best = &p;
  }
  const double score = best->likelihood / static_cast<double>(config_.bins);
  updates_below_ = score < config_.threshold ? updates_below_ + 1 : 0;
  if (tracking_) {
    estimate_ = {true, false, mean, score};
    tracking_ = updates_below_ < config_.lost_updates;
  } else {
    estimate_ = {true, false, best->circle, score};
    tracking_ = updates_below_ == 0;
  }
  if (!tracking_) return;
  if (static_cast<double>(count_) - window > window_slack) {
    count_ = std::min(count_, static_cast<std::size_t>(std::max(window, least_events)));
  }
  count_ = std::min(count_, most_events);
  resample();
}

/// Every particle becomes a circle through three events near each other.
void ParticleFilter::search() {
  for (std::size_t i = 0; i < particles_.size(); ++i) {
    particles_[i].circle = through_three_events(i);
    particles_[i].weight = 1.0 / static_cast<double>(particles_.size());
  }
}

Circle ParticleFilter::through_three_events(std::size_t particle) const {
  std::uint64_t next = 0;
  const auto draw = [&] {
    const Pixel& p =
        event(static_cast<std::size_t>(uniform(particle, next++, 0.0, static_cast<double>(count_))));
    return std::array<double, 2>{static_cast<double>(p.x), static_cast<double>(p.y)};
  };
  const auto first = draw();
  for (std::uint64_t i = 0; i < tries; ++i) {
    const Circle c = circle_through(first, draw(), draw());
    const bool inside = c.x_px >= 0 && c.y_px >= 0 && c.x_px <= size_.width && c.y_px <= size_.height;
    if (inside && c.r_px >= config_.radius_px[0] && c.r_px <= config_.radius_px[1]) return c;
  }
  return {uniform(particle, next, 0.0, size_.width), uniform(particle, next + 1, 0.0, size_.height),
          uniform(particle, next + 2, config_.radius_px[0], config_.radius_px[1])};
}

void ParticleFilter::observe(Particle& p) {
  const Circle& c = p.circle;
  const double outer_px = 1.0 + config_.inlier_px;
  const auto bins = static_cast<double>(config_.bins);
  const double penalty = config_.negative_bias * bins / (std::numbers::pi * c.r_px * c.r_px);
  p.likelihood = config_.min_likelihood * bins;
  p.window = static_cast<double>(count_);
  std::fill(covered_.begin(), covered_.end(), 0.0);
  double score = 0.0;
  for (std::size_t age = 0; age < count_; ++age) {
    const Pixel& e = event(age);
    const int dx = static_cast<int>(e.x - c.x_px);
    const int dy = static_cast<int>(e.y - c.y_px);
    if (std::abs(dx) > table_px_ || std::abs(dy) > table_px_) continue;
    const Polar& polar =
        polar_[static_cast<std::size_t>((dy + table_px_) * (2 * table_px_ + 1) + dx + table_px_)];
    const double off_px = static_cast<double>(polar.distance_px) - c.r_px;
    if (off_px > outer_px) continue;
    const double on_outline = std::min(1.0, std::max(0.0, (outer_px - std::abs(off_px)) / config_.inlier_px));
    if (on_outline == 0.0) {
      score -= penalty;
      continue;
    }
    double& covered = covered_[polar.bin];
    if (on_outline <= covered) continue;
    score += on_outline - covered;
    covered = on_outline;
    if (score < p.likelihood) continue;
    p.likelihood = score;
    p.window = static_cast<double>(age);
  }
  p.weight *= p.likelihood;
}

/// Draws the particles of the next update from those of this one by weight, and moves them.
void ParticleFilter::resample() {
  parents_.swap(particles_);
  for (std::size_t i = 0; i < particles_.size(); ++i) {
    const double share = uniform(i, resample_numbers, 0.0, 1.0);
    std::size_t parent = 0;
    double sum = parents_[0].weight;
    while (sum < share && parent + 1 < parents_.size()) sum += parents_[++parent].weight;
    particles_[i] = parents_[parent];
    Circle& c = particles_[i].circle;
    const double reach_px = config_.motion_px;
    c.x_px = std::clamp(c.x_px + uniform(i, resample_numbers + 1, -reach_px, reach_px), 0.0,
                        static_cast<double>(size_.width));
    c.y_px = std::clamp(c.y_px + uniform(i, resample_numbers + 2, -reach_px, reach_px), 0.0,
                        static_cast<double>(size_.height));
    const double reach_r_px = radius_motion_share * reach_px;
    c.r_px = std::clamp(c.r_px + uniform(i, resample_numbers + 3, -reach_r_px, reach_r_px),
                        config_.radius_px[0], config_.radius_px[1]);
  }
}

}  // namespace saccade
