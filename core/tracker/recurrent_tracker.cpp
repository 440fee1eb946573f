#include "core/tracker/recurrent_tracker.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "core/time_stamp.h"

namespace saccade {
namespace {

constexpr std::int64_t never_us = std::numeric_limits<std::int64_t>::min();
constexpr std::int64_t latest_us = std::numeric_limits<std::int64_t>::max();
constexpr std::int64_t tick_us = 1'000;
constexpr std::size_t prefetched_events = 24;
constexpr std::int64_t multiplications_per_tick = 3'000'000;  // 12 ms for a step at 128x128
constexpr std::int64_t shortest_step_us = 8'000;              // within the steps of the training, 5 to 14 ms
// Noise of the process, per square root of a second: a thrown or bounced ball turns within some ten ms.
constexpr double acceleration_px_s2 = 1'500.0, growth_px_s = 8.0, drift_px_s = 15.0;
// Least standard deviations of a measurement; the network states its own for centre and radius.
constexpr double least_centre_sd_px = 0.5, least_radius_sd_px = 0.3;
constexpr double least_speed_sd_px_s = 25.0, speed_sd_share = 0.4;
// A circle and a track are of the same ball within so many radii (and two standard deviations), and this ratio of radii.
constexpr double gate_radii = 0.5, gate_log_ratio = 0.35;
constexpr double least_found_log_odds = -5.0;  // less is never the ball
constexpr double birth_log_odds = -2.0, death_log_odds = -6.0;
constexpr double birth_share = 0.6;       // a new track has this share of its circle's log odds, less one
constexpr double missed_log_odds = -4.0;  // of a track that no circle of the step fits
constexpr double memory_us = 40'000.0;    // time constant of the mean of log odds
constexpr double model_sd_px = 0.5;       // of the estimate, beside the track's covariance

}  // namespace

void describe(FieldVisitor& v, RecurrentTrackerConfig& c) {
  describe_radius_px(v, c.radius_px);
  v.real("threshold", c.threshold, {0.0, 1.0},
         "existence probability from which on a circle is taken for the ball");
  v.real("hold_s", c.hold_s, {0.0, 60.0}, "for which a circle that is not measured is held");
  v.model("model", c.model, "weights of the network, an NPZ file; empty: those of this program");
  const std::string problem = problem_of_recurrent(c.model);
  v.require(problem.empty(), "model", problem, "the arrays of models/recurrent/weights.npz");
}

RecurrentTracker::RecurrentTracker(const RecurrentTrackerConfig& config, const Camera& camera)
    : config_(check_config("detector", config)),
      camera_(camera),
      sieve_(camera.size),
      surface_(camera.size),
      network_(recurrent_model_of(config.model), camera.size, config.radius_px[0], config.radius_px[1]),
      now_us_(never_us),
      step_us_(never_us) {
  rays_.reserve(static_cast<std::size_t>(camera.size.pixels()));
  for (int y = 0; y < camera.size.height; ++y) {
    for (int x = 0; x < camera.size.width; ++x) rays_.push_back(camera.ray(x, y));
  }
}

void RecurrentTracker::set_motion(const CameraMotion* motion) {
  rotation_rad_s_.reset();
  if (motion != nullptr) rotation_rad_s_ = motion->angular_velocity_rad_s;
}

Eigen::Vector2d RecurrentTracker::camera_flow_px_s(const Eigen::Vector2d& at) const {
  if (!rotation_rad_s_) return Eigen::Vector2d::Zero();
  const int x = static_cast<int>(std::clamp(at.x(), 0.0, static_cast<double>(camera_.size.width - 1)));
  const int y = static_cast<int>(std::clamp(at.y(), 0.0, static_cast<double>(camera_.size.height - 1)));
  return camera_.rotational_flow_px_s(rays_[static_cast<std::size_t>(y * camera_.size.width + x)],
                                      *rotation_rad_s_);
}

void RecurrentTracker::process(std::span<const Event> events, const CameraMotion* motion) {
  set_motion(motion);
  for (std::size_t i = 0; i < events.size(); ++i) {
    if (i + prefetched_events < events.size() && !sieve_.is_outside(events[i + prefetched_events]))
      surface_.prefetch(events[i + prefetched_events]);
    if (!sieve_.accept(events[i])) continue;
    run_until(events[i].t_us, false);
    surface_.add(events[i]);
  }
}

void RecurrentTracker::advance_to(std::int64_t now_us, const CameraMotion* motion) {
  set_motion(motion);
  run_until(now_us, true);
}

/// Brings what happens at every tick up to t_us.
void RecurrentTracker::run_until(std::int64_t t_us, bool inclusive) {
  if (t_us < now_us_) return;
  now_us_ = t_us;
  const std::int64_t since_tick_us = (t_us % tick_us + tick_us) % tick_us;
  if (!next_tick_us_) next_tick_us_ = saturated_sum(t_us, tick_us - since_tick_us);
  while (*next_tick_us_ != latest_us && (*next_tick_us_ < t_us || (inclusive && *next_tick_us_ == t_us))) {
    tick(*next_tick_us_);
    *next_tick_us_ = saturated_sum(*next_tick_us_, tick_us);
  }
}

void RecurrentTracker::tick(std::int64_t now_us) {
  constexpr double dt_s = static_cast<double>(tick_us) * 1e-6;
  for (Track& track : tracks_) {
    if (track.alive) predict(track, dt_s);
  }
  rotation_known_ = rotation_known_ && rotation_rad_s_.has_value();
  image_shift_px_ +=
      dt_s * camera_flow_px_s({0.5 * (camera_.size.width - 1), 0.5 * (camera_.size.height - 1)});
  if (!network_.busy() &&
      (step_us_ == never_us || saturated_difference(now_us, step_us_) >= shortest_step_us)) {
    network_.begin(now_us, rotation_known_ ? std::optional(image_shift_px_) : std::nullopt);
    step_us_ = now_us;
    image_shift_px_.setZero();
    rotation_known_ = rotation_rad_s_.has_value();
  }
  if (network_.work(surface_, multiplications_per_tick)) take_found(now_us);
}

void RecurrentTracker::predict(Track& track, double dt_s) {
  track.camera_px_s = camera_flow_px_s(track.state.head<2>());
  track.state.head<2>() += dt_s * (track.state.tail<2>() + track.camera_px_s);
  Covariance& p = track.covariance;
  Covariance move = Covariance::Identity();
  move(0, 3) = move(1, 4) = dt_s;
  p = move * p * move.transpose();
  p.diagonal().head<2>().array() += drift_px_s * drift_px_s * dt_s;
  p(2, 2) += growth_px_s * growth_px_s * dt_s;
  p.diagonal().tail<2>().array() += acceleration_px_s2 * acceleration_px_s2 * dt_s;
  const auto inside = [](double at, int pixels) { return at >= -0.5 && at < pixels - 0.5; };
  track.alive = inside(track.state.x(), camera_.size.width) && inside(track.state.y(), camera_.size.height) &&
                static_cast<double>(saturated_difference(now_us_, track.measured_us)) <= config_.hold_s * 1e6;
}

/// The network's result: measurements, tracks that begin and end.
void RecurrentTracker::take_found(std::int64_t now_us) {
  const double late_s = difference_s(now_us, network_.found_at_us());
  for (Track& track : tracks_) track.taken = false;
  const double share = 1.0 - std::exp(-std::max(difference_s(now_us, step_us_), 0.008) * 1e6 / memory_us);
  for (const RecurrentNetwork::Found& found : network_.found()) {
    if (found.inlier_log_odds < least_found_log_odds || found.circle.r_px < config_.radius_px[0] - 1.0 ||
        found.circle.r_px > config_.radius_px[1] + 1.0)
      continue;
    Track* nearest = nullptr;
    double least = std::numeric_limits<double>::max();
    bool same = false;
    for (Track& track : tracks_) {
      if (!track.alive) continue;
      const Eigen::Vector2d at =
          Eigen::Vector2d(found.circle.x_px, found.circle.y_px) + late_s * found.speed_px_s;
      const double off = (track.state.head<2>() - at).norm() / found.circle.r_px;
      const double ratio = std::abs(std::log(track.state[2] / found.circle.r_px));
      const double distance = off * off + 2.0 * ratio * ratio;
      const double sd = std::sqrt(track.covariance(0, 0)) / found.circle.r_px;
      if (off > gate_radii + 2.0 * sd || ratio > gate_log_ratio) continue;
      same = true;
      if (!track.taken && distance < least) {
        least = distance;
        nearest = &track;
      }
    }
    if (nearest != nullptr) {
      nearest->taken = true;
      nearest->measured_us = now_us;
      measure(*nearest, found, late_s);
      nearest->log_odds += share * (found.inlier_log_odds - nearest->log_odds);
    } else if (!same && found.inlier_log_odds > birth_log_odds) {
      begin_track(found, late_s, now_us);
    }
  }
  for (Track& track : tracks_) {
    if (!track.alive) continue;
    if (!track.taken) track.log_odds += share * (missed_log_odds - track.log_odds);
    track.alive = track.log_odds > death_log_odds;
  }
}

void RecurrentTracker::measure(Track& track, const RecurrentNetwork::Found& found, double late_s) const {
  State z;
  z << found.circle.x_px + late_s * found.speed_px_s.x(), found.circle.y_px + late_s * found.speed_px_s.y(),
      found.circle.r_px, found.speed_px_s - track.camera_px_s;
  const double centre_sd = std::max(least_centre_sd_px, found.centre_sd_px);
  const double radius_sd = std::max(least_radius_sd_px, found.radius_sd_px);
  const double speed_sd = least_speed_sd_px_s + speed_sd_share * found.speed_px_s.norm();
  // Each number alone: the measurement's errors are taken for independent.
  const double variances[5] = {centre_sd * centre_sd, centre_sd * centre_sd, radius_sd * radius_sd,
                               speed_sd * speed_sd, speed_sd * speed_sd};
  for (int i = 0; i < 5; ++i) {
    const State gain = track.covariance.col(i) / (track.covariance(i, i) + variances[i]);
    track.state += gain * (z[i] - track.state[i]);
    const Eigen::Matrix<double, 1, 5> row = track.covariance.row(i);
    track.covariance -= gain * row;
  }
}

void RecurrentTracker::begin_track(const RecurrentNetwork::Found& found, double late_s, std::int64_t now_us) {
  Track* place = tracks_.data();
  for (Track& track : tracks_) {
    if (!track.alive) {
      place = &track;
      break;
    }
    if (track.log_odds < place->log_odds) place = &track;
  }
  const double log_odds = birth_share * found.inlier_log_odds - 1.0;
  if (place->alive && place->log_odds >= log_odds) return;
  Track track;
  track.alive = true;
  const Eigen::Vector2d at =
      Eigen::Vector2d(found.circle.x_px, found.circle.y_px) + late_s * found.speed_px_s;
  track.camera_px_s = camera_flow_px_s(at);
  track.state << at, found.circle.r_px, found.speed_px_s - track.camera_px_s;
  const double speed_sd = least_speed_sd_px_s + speed_sd_share * found.speed_px_s.norm();
  track.covariance = Covariance::Zero();
  track.covariance.diagonal() << found.centre_sd_px * found.centre_sd_px,
      found.centre_sd_px * found.centre_sd_px, found.radius_sd_px * found.radius_sd_px, speed_sd * speed_sd,
      speed_sd * speed_sd;
  track.log_odds = log_odds;
  track.measured_us = now_us;
  track.taken = true;
  *place = track;
}

const RecurrentTracker::Track* RecurrentTracker::best() const {
  const Track* best = nullptr;
  for (const Track& track : tracks_) {
    if (track.alive && (best == nullptr || track.log_odds > best->log_odds)) best = &track;
  }
  return best;
}

Estimate RecurrentTracker::estimate() {
  const Track* track = best();
  if (track == nullptr) return {};
  const double since_s =
      next_tick_us_ ? difference_s(now_us_, saturated_difference(*next_tick_us_, tick_us)) : 0.0;
  const Eigen::Vector2d at = track->state.head<2>() + since_s * (track->state.tail<2>() + track->camera_px_s);
  const double r_px = std::clamp(track->state[2], config_.radius_px[0], config_.radius_px[1]);
  Eigen::Matrix3d covariance = track->covariance.topLeftCorner<3, 3>();
  covariance.diagonal().array() += model_sd_px * model_sd_px;
  return {true, false, {at.x(), at.y(), r_px}, 1.0 / (1.0 + std::exp(-track->log_odds)), covariance};
}

}  // namespace saccade
