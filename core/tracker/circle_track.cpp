#include "core/tracker/circle_track.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace saccade {
namespace {

// Noise of one edge. Edges of one crossing of a pixel are not independent: more than their half pixel.
constexpr double edge_sd_px = 1.0;
constexpr double single_flow_sd_share = 1.0;  // of a single measured flow
constexpr double single_flow_sd_px_s = 30.0;
constexpr double outlier_sd = 3.0;
constexpr double apart_px_s = 10.0;  // circle and room differ enough in speed to tell their edges apart

// How a ball in a hand moves: it may start at any time, and turn as tightly as on a circle of turn_px; turns that last are
// wider. A circle that moves slowly in the image while the camera turns fast is one that the gaze follows. It turns with
// the camera, so tighter turns are expected.
constexpr double start_px_s2 = 80.0;
constexpr double turn_px = 30.0;
constexpr double lasting_turn_px = 60.0, lasting_turn_in_pursuit_px = 20.0, turn_lasts_s = 0.15;
constexpr double pursuit_share =
    0.3;  // of the camera's image motion: what the gaze follows is slower in the image
constexpr double growth_start_px_s2 = 20.0;
constexpr double growth_per_speed_1_s = 1.0;
constexpr double acceleration_lasts_s = 0.01;
constexpr double growth_lasts_s = 0.05;

constexpr double unknown_speed_px_s = 500.0;
constexpr double unknown_growth_px_s = 30.0;
// The latency of the outline's events changes with what is behind the outline; without new edges it returns to 0.
constexpr double latency_sd_s = 0.005;
constexpr double latency_lasts_s = 2.0;
constexpr double longest_latency_s = 0.02;
constexpr double latency_memory_s = 0.008;  // a latency shows in the motion averaged over that time
constexpr double silent_px = 2.0;           // an outline that moved so far would have made events
constexpr double silent_s = 0.002;          // and no sooner
constexpr double jitter_px_s = 15.0;
constexpr double slowest_px_s = 20.0;

}  // namespace

CircleTrack::CircleTrack(const Circle& circle, std::int64_t now_us) : t_us_(now_us), last_edge_us_(now_us) {
  state_ << circle.x_px, circle.y_px, circle.r_px, 0, 0, 0, 0, 0, 0;
  const double v = unknown_speed_px_s * unknown_speed_px_s;
  covariance_.diagonal() << 2.0, 2.0, 1.0, v, v, unknown_growth_px_s * unknown_growth_px_s,
      latency_sd_s * latency_sd_s, 0.0, 0.0;
}

void CircleTrack::predict(std::int64_t t_us, const Eigen::Vector2d& camera_flow_px_s) {
  if (t_us <= t_us_) return;
  const double dt = difference_s(t_us, t_us_);
  t_us_ = t_us;
  const double speed2 = state_.segment<2>(3).squaredNorm();
  const Eigen::Vector2d image_px_s = state_.segment<2>(3) + camera_flow_px_s;
  carried_px_ += image_px_s * dt;
  state_.head<2>() += image_px_s * dt;
  const double late = 1.0 - std::exp(-dt / latency_memory_s);
  late_own_px_s_ += (state_.segment<2>(3) - late_own_px_s_) * late;
  late_camera_px_s_ += (camera_flow_px_s - late_camera_px_s_) * late;
  state_[2] += state_[5] * dt;
  const double decay = std::exp(-dt / growth_lasts_s);
  state_[5] *= decay;
  Covariance transition = Covariance::Identity();
  transition.block<3, 3>(0, 3).diagonal().setConstant(dt);
  transition(5, 5) = decay;
  transition.block<2, 2>(3, 7).diagonal().setConstant(dt);
  const double turns_on = std::exp(-dt / turn_lasts_s);
  transition.block<2, 2>(7, 7).diagonal().setConstant(turns_on);
  state_.segment<2>(3) += state_.tail<2>() * dt;
  state_.tail<2>() *= turns_on;
  transition(6, 6) = std::exp(-dt / latency_lasts_s);
  state_[6] *= transition(6, 6);
  covariance_ = transition * covariance_ * transition.transpose();
  covariance_(6, 6) += latency_sd_s * latency_sd_s * (1.0 - transition(6, 6) * transition(6, 6));
  const double turn = start_px_s2 + speed2 / turn_px;
  const bool in_pursuit =
      image_px_s.squaredNorm() < pursuit_share * pursuit_share * camera_flow_px_s.squaredNorm();
  const double lasting_turn = speed2 / (in_pursuit ? lasting_turn_in_pursuit_px : lasting_turn_px);
  covariance_.diagonal().tail<2>().array() += lasting_turn * lasting_turn * (1.0 - turns_on * turns_on);
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

CircleTrack::State CircleTrack::covariance_with(const State& gradient) const {
  State sum = State::Zero();
  for (Eigen::Index i = 0; i < gradient.size(); ++i) {
    if (gradient[i] != 0.0) sum += gradient[i] * covariance_.col(i);  // most are 0
  }
  return sum;
}

void CircleTrack::update(const State& gradient, const State& covariance_with_gradient, double innovation,
                         double variance) {
  const double s = gradient.dot(covariance_with_gradient) + variance;
  state_ += covariance_with_gradient * (innovation / s);
  covariance_ -= covariance_with_gradient * covariance_with_gradient.transpose() / s;
  state_[6] = std::clamp(state_[6], 0.0, longest_latency_s);
}

bool CircleTrack::measure(const Edge& edge, double clarity, Learn learn,
                          const Eigen::Vector2d& camera_flow_px_s) {
  const double dt = difference_s(edge.t_us, t_us_);
  const Eigen::Vector2d offset =
      Eigen::Vector2d(edge.x, edge.y) - centre() + lag_px() - (state_.segment<2>(3) + camera_flow_px_s) * dt;
  const double distance = offset.norm();
  const double off = distance - state_[2];
  const double gate = std::min(3.0, 1.0 + 0.35 * state_[2]);
  if (distance < 1.0 || !(std::abs(off) <= gate)) return false;
  const Eigen::Vector2d normal = offset / distance;
  const double alignment = edge.along.dot(normal);
  if (std::abs(alignment) < min_alignment) return false;

  // An edge that moves as the room behind it and not as the circle is not of its outline.
  const double room = camera_flow_px_s.dot(normal);
  const double own = room + state_.segment<2>(3).dot(normal);
  const double seen = std::copysign(edge.speed_px_s, alignment);
  if (std::abs(own - room) > apart_px_s && std::abs(seen - room) < 0.5 * std::abs(seen - own)) return false;

  State place;
  place << -normal, -1.0, 0.0, 0.0, 0.0, normal.dot(latency_gradient_px_s()), 0.0, 0.0;
  State with_place = covariance_with(place);
  const double variance = place.dot(with_place) + edge_sd_px * edge_sd_px;
  if (off * off > outlier_sd * outlier_sd * variance) return false;
  if (learn == Learn::place_and_speed) {
    State speed;
    speed << 0.0, 0.0, 0.0, normal, 0.0, 0.0, 0.0, 0.0;
    const double sd = single_flow_sd_share * std::abs(seen) + single_flow_sd_px_s;
    const double innovation = seen - own;
    const State with_speed = covariance_with(speed);
    const double speed_variance = speed.dot(with_speed) + sd * sd;
    if (innovation * innovation > outlier_sd * outlier_sd * speed_variance) return false;
    update(speed, with_speed, innovation, sd * sd);
    with_place = covariance_with(place);
  }
  // The probability that the edge is of the outline and not of the clutter around it.
  const double of_outline =
      clarity * std::exp(-0.5 * off * off / variance) / std::sqrt(2.0 * std::numbers::pi * variance);
  const double of_clutter = (1.0 - clarity) / (2.0 * gate);
  const double own_probability = of_outline / (of_outline + of_clutter + 1e-9);
  update(place, with_place, -off, edge_sd_px * edge_sd_px / (own_probability * own_probability + 1e-3));
  last_edge_us_ = std::max(last_edge_us_, edge.t_us);
  resting_ = false;
  return own_probability > 0.1;
}

void CircleTrack::set_speed(const Eigen::Vector2d& speed_px_s, double growth_px_s) {
  state_.segment<3>(3) << speed_px_s, growth_px_s;
  state_.tail<2>().setZero();
  const double sd = 0.3 * speed_px_s.norm() + single_flow_sd_px_s;
  // A new measurement: what the old speed had in common with the place is gone.
  covariance_.middleCols<3>(3).setZero();
  covariance_.middleRows<3>(3).setZero();
  covariance_.middleCols<2>(7).setZero();
  covariance_.middleRows<2>(7).setZero();
  const double lasting_turn = speed_px_s.squaredNorm() / lasting_turn_px;
  covariance_.diagonal().tail<2>().setConstant(lasting_turn * lasting_turn);
  covariance_.diagonal().segment<3>(3) << sd * sd, sd * sd, unknown_growth_px_s * unknown_growth_px_s;
}

Eigen::Vector2d CircleTrack::latency_gradient_px_s() const {
  const double camera2 = late_camera_px_s_.squaredNorm();
  const double share = camera2 / (camera2 + late_own_px_s_.squaredNorm() + 1.0);
  return share * (late_own_px_s_ + late_camera_px_s_);
}

void CircleTrack::inflate(const Eigen::Vector3d& sd_px) {
  for (int i = 0; i < 3; ++i) covariance_(i, i) = std::max(covariance_(i, i), sd_px[i] * sd_px[i]);
}

void CircleTrack::correct(const Circle& shown, const Eigen::Vector3d& sd_px) {
  const double place[3] = {shown.x_px, shown.y_px, shown.r_px};
  for (int i = 0; i < 3; ++i) {
    State gradient = State::Zero();
    gradient[i] = 1.0;
    double predicted = state_[i];
    if (i < 2) {
      gradient[6] = -latency_gradient_px_s()[i];
      predicted -= lag_px()[i];
    }
    update(gradient, covariance_with(gradient), place[i] - predicted, sd_px[i] * sd_px[i]);
  }
}

bool CircleTrack::rest_if_silent(const Eigen::Vector2d& camera_flow_px_s) {
  const double speed = (state_.segment<2>(3) + camera_flow_px_s).norm();
  resting_ =
      resting_ || static_cast<double>(silent_us()) * 1e-6 > silent_s + silent_px / (speed + slowest_px_s);
  if (!resting_) return false;
  state_.segment<2>(3) += 0.2 * (-camera_flow_px_s - state_.segment<2>(3));
  state_[5] *= 0.8;
  state_.tail<2>() *= 0.8;
  covariance_.middleRows<3>(3) *= 0.9;
  covariance_.middleCols<3>(3) *= 0.9;
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
  const double dt = difference_s(t_us, t_us_);
  const Eigen::Vector2d at = centre() + (state_.segment<2>(3) + camera_flow_px_s) * dt;
  return {at.x(), at.y(), state_[2]};
}

}  // namespace saccade
