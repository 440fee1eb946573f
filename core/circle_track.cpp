#include "core/circle_track.h"

#include <algorithm>
#include <cmath>

namespace saccade {
namespace {

// Noise of one edge. Edges of one crossing of a pixel are not independent: more than their half pixel.
constexpr double edge_sd_px = 1.0;
constexpr double speed_sd_share = 1.0;  // of a single measured flow
constexpr double speed_sd_px_s = 30.0;
constexpr double outlier_sd = 3.0;
constexpr double apart_px_s = 10.0;  // circle and room differ enough in speed to tell their edges apart

// How a ball in a hand moves: it may start at any time, and turn as tightly as on a circle of turn_px.
constexpr double start_px_s2 = 80.0;
constexpr double turn_px = 30.0;
constexpr double growth_start_px_s2 = 20.0;
constexpr double growth_per_speed_1_s = 1.0;
constexpr double acceleration_lasts_s = 0.01;
constexpr double growth_lasts_s = 0.05;

constexpr double unknown_speed_px_s = 500.0;
constexpr double unknown_growth_px_s = 30.0;
constexpr double silent_px = 2.0;   // an outline that moved so far would have been heard
constexpr double silent_s = 0.002;  // and no sooner
constexpr double jitter_px_s = 15.0;
constexpr double slowest_px_s = 20.0;

}  // namespace

CircleTrack::CircleTrack(const Circle& circle, std::int64_t now_us) : t_us_(now_us), last_edge_us_(now_us) {
  state_ << circle.x_px, circle.y_px, circle.r_px, 0, 0, 0;
  const double v = unknown_speed_px_s * unknown_speed_px_s;
  covariance_.diagonal() << 2.0, 2.0, 1.0, v, v, unknown_growth_px_s * unknown_growth_px_s;
}

void CircleTrack::predict(std::int64_t t_us, const Eigen::Vector2d& camera_flow_px_s) {
  if (t_us <= t_us_) return;
  const double dt = static_cast<double>(t_us - t_us_) * 1e-6;
  t_us_ = t_us;
  const double speed2 = state_.segment<2>(3).squaredNorm();
  const Eigen::Vector2d carried = (state_.segment<2>(3) + camera_flow_px_s) * dt;
  carried_px_ += carried;
  state_.head<2>() += carried;
  state_[2] += state_[5] * dt;
  const double decay = std::exp(-dt / growth_lasts_s);
  state_[5] *= decay;
  Covariance f = Covariance::Identity();
  f.topRightCorner<3, 3>().diagonal().setConstant(dt);
  f(5, 5) = decay;
  covariance_ = f * covariance_ * f.transpose();
  const double turn = start_px_s2 + speed2 / turn_px;
  const double grow = growth_start_px_s2 + growth_per_speed_1_s * std::sqrt(speed2);
  for (int i = 0; i < 3; ++i) {  // white acceleration
    const double a = i < 2 ? turn : grow;
    const double q = a * a * acceleration_lasts_s;
    covariance_(i, i) += q * dt * dt * dt / 3.0;
    covariance_(i, i + 3) += q * dt * dt / 2.0;
    covariance_(i + 3, i) += q * dt * dt / 2.0;
    covariance_(i + 3, i + 3) += q * dt;
  }
}

void CircleTrack::update(const State& gradient, double innovation, double variance) {
  const State ph = covariance_ * gradient;
  const double s = gradient.dot(ph) + variance;
  state_ += ph * (innovation / s);
  covariance_ -= ph * ph.transpose() / s;
}

bool CircleTrack::measure(const Edge& edge, double clarity, Learn learn,
                          const Eigen::Vector2d& camera_flow_px_s) {
  const Eigen::Vector2d offset = Eigen::Vector2d(edge.x, edge.y) - centre();
  const double distance = offset.norm();
  const double off = distance - state_[2];
  const double gate = std::min(3.0, 1.0 + 0.35 * state_[2]) * (0.7 + 0.3 * clarity);
  if (distance < 1.0 || !(std::abs(off) <= gate)) return false;
  const Eigen::Vector2d normal = offset / distance;
  const double slowness = edge.gradient_us_px.norm();
  const double alignment = edge.gradient_us_px.dot(normal) / slowness;
  if (std::abs(alignment) < min_alignment) return false;

  // An edge that moves as the room behind it and not as the circle is not of its outline.
  const double room = camera_flow_px_s.dot(normal);
  const double own = room + state_.segment<2>(3).dot(normal);
  const double seen = std::copysign(1e6 / slowness, alignment);
  if (std::abs(own - room) > apart_px_s && std::abs(seen - room) < 0.5 * std::abs(seen - own)) return false;

  State place;
  place << -normal, -1.0, 0.0, 0.0, 0.0;
  const double place_variance = place.dot(covariance_ * place);
  if (off * off > outlier_sd * outlier_sd * (place_variance + edge_sd_px * edge_sd_px)) return false;
  if (learn == Learn::place_and_speed) {
    State speed;
    speed << 0.0, 0.0, 0.0, normal, 0.0;
    const double measured = std::copysign(1e6 / slowness, alignment);
    const double sd = speed_sd_share * std::abs(measured) + speed_sd_px_s;
    const double innovation = measured - (state_.segment<2>(3) + camera_flow_px_s).dot(normal);
    const double variance = speed.dot(covariance_ * speed) + sd * sd;
    if (innovation * innovation > outlier_sd * outlier_sd * variance) return false;
    update(speed, innovation, sd * sd);
  }
  update(place, -off, edge_sd_px * edge_sd_px / (0.03 + clarity * clarity));
  last_edge_us_ = std::max(last_edge_us_, edge.t_us);
  resting_ = false;
  return true;
}

void CircleTrack::doubt() {
  for (int i = 0; i < 3; ++i) covariance_(i, i) = std::max(covariance_(i, i), 0.25);
}

void CircleTrack::correct(const Circle& circle, const Eigen::Vector3d& sd_px) {
  const double fitted[3] = {circle.x_px, circle.y_px, circle.r_px};
  for (int i = 0; i < 3; ++i) {
    State unit = State::Zero();
    unit[i] = 1.0;
    update(unit, fitted[i] - state_[i], sd_px[i] * sd_px[i]);
  }
}

bool CircleTrack::rest_if_silent(const Eigen::Vector2d& camera_flow_px_s) {
  const double speed = (state_.segment<2>(3) + camera_flow_px_s).norm();
  resting_ =
      resting_ || static_cast<double>(silent_us()) * 1e-6 > silent_s + silent_px / (speed + slowest_px_s);
  if (!resting_) return false;
  state_.segment<2>(3) += 0.2 * (-camera_flow_px_s - state_.segment<2>(3));
  state_[5] *= 0.8;
  covariance_.bottomRows<3>() *= 0.9;
  covariance_.rightCols<3>() *= 0.9;
  return speed > jitter_px_s;
}

void CircleTrack::bound(double r_min_px, double r_max_px) {
  constexpr double max_sd[3] = {1.5, 1.5, 1.0};
  for (int i = 0; i < 3; ++i) {
    const double variance = covariance_(i, i);
    if (variance <= max_sd[i] * max_sd[i]) continue;
    const double scale = max_sd[i] / std::sqrt(variance);
    covariance_.row(i) *= scale;
    covariance_.col(i) *= scale;
  }
  state_[2] = std::clamp(state_[2], r_min_px - 0.5, r_max_px + 0.5);
}

Circle CircleTrack::circle_at(std::int64_t t_us, const Eigen::Vector2d& camera_flow_px_s) const {
  const double dt = static_cast<double>(t_us - t_us_) * 1e-6;
  const Eigen::Vector2d at = centre() + (state_.segment<2>(3) + camera_flow_px_s) * dt;
  return {at.x(), at.y(), state_[2]};
}

}  // namespace saccade
