#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "core/camera.h"
#include "core/time_stamp.h"
#include "core/tracker/edge_map.h"

namespace saccade {

/// An extended Kalman filter of one circle. Every edge on the outline is a measurement at its own time (paper, section
/// V: an event-driven filter with outlier rejection).
///
/// State: centre and radius, px, their speeds, px/s, the latency of the outline's events, s, and the acceleration of the
/// centre, px/s^2, of turns that last. The centre's speed is what is left beside the image motion that the camera's own
/// rotation makes, so that a camera that turns carries the circle along. The pixels of a dark outline respond
/// milliseconds late (the bandwidth of a pixel falls with its light), so that edges show the circle where it was a
/// latency ago: shown(). An edge at p measures |p - shown centre| - radius = 0. Edges off the outline, or that do not
/// move along its normal, are outliers.
class CircleTrack {
 public:
  /// cos of the largest angle between an edge's flow and the outline's normal.
  static constexpr double min_alignment = 0.866;  // 30 deg

  /// At rest, at `circle`, its speed unknown.
  CircleTrack(const Circle& circle, std::int64_t now_us);
  CircleTrack() = default;

  /// Moves on to t_us (earlier than now: no change). `camera_flow_px_s` is the image motion at the circle
  /// that the camera's rotation makes.
  void predict(std::int64_t t_us, const Eigen::Vector2d& camera_flow_px_s);

  enum class Learn { place, place_and_speed };
  /// Takes an edge, weighted by the probability that it is of the outline and not of the clutter around it. False for an
  /// outlier, and where that probability is below 0.1. `clarity` in [0, 1]: the share of the edges near the circle that
  /// are of its outline. The edge is compared with the circle at its own time, from the last predict() on.
  bool measure(const Edge& edge, double clarity, Learn learn, const Eigen::Vector2d& camera_flow_px_s);

  /// The measured speed of the centre beside the camera's, and of the radius.
  void set_speed(const Eigen::Vector2d& speed_px_s, double growth_px_s);
  /// Shown at another place, with the same speed.
  void place(const Circle& shown) {
    state_.head<3>() << shown.x_px, shown.y_px, shown.r_px;
    state_.head<2>() += lag_px();
  }
  /// Inflates the covariance: the standard deviations of centre and radius (x, y, r) are at least `sd_px`.
  void inflate(const Eigen::Vector3d& sd_px);
  void inflate(double sd_px) { inflate(Eigen::Vector3d::Constant(sd_px)); }
  /// A measurement of centre and radius, from the same outline as the edges.
  void correct(const Circle& shown, const Eigen::Vector3d& sd_px);
  /// How far its motion alone has carried the circle since it began: what correcting and measuring did left out.
  [[nodiscard]] const Eigen::Vector2d& carried_px() const { return carried_px_; }

  /// Sets the speed in the image to zero where no edge came for longer than an outline at the speed of the state takes to
  /// make one, followed by the gaze or not. True where that speed was above the jitter, and so wrong.
  bool rest_if_silent(const Eigen::Vector2d& camera_flow_px_s);

  /// Bounds the covariance by what is possible without events, and the radius to [r_min - 1/2, r_max + 1/2].
  void bound(double r_min_px, double r_max_px);

  [[nodiscard]] Circle circle() const { return {state_[0], state_[1], state_[2]}; }
  /// Where the edges of now show it: its latency ago.
  [[nodiscard]] Circle shown() const {
    return {state_[0] - lag_px().x(), state_[1] - lag_px().y(), state_[2]};
  }
  [[nodiscard]] double latency_s() const { return state_[6]; }
  [[nodiscard]] Eigen::Matrix3d covariance() const { return covariance_.topLeftCorner<3, 3>(); }
  [[nodiscard]] Eigen::Vector2d centre() const { return state_.head<2>(); }
  /// Of the centre, beside what the camera's rotation does.
  [[nodiscard]] Eigen::Vector2d speed_px_s() const { return state_.segment<2>(3); }
  /// Where the circle will be, or was, at t_us by its speed.
  [[nodiscard]] Circle circle_at(std::int64_t t_us, const Eigen::Vector2d& camera_flow_px_s) const;
  [[nodiscard]] double growth_px_s() const { return state_[5]; }
  [[nodiscard]] std::int64_t time_us() const { return t_us_; }
  /// Since the last edge that was no outlier.
  [[nodiscard]] std::int64_t silent_us() const { return saturated_difference(t_us_, last_edge_us_); }

 private:
  using State = Eigen::Matrix<double, 9, 1>;  // x, y, r, their speeds, the latency, and the acceleration
  using Covariance = Eigen::Matrix<double, 9, 9>;

  /// The covariance times a measurement's gradient.
  [[nodiscard]] State covariance_with(const State& gradient) const;
  void update(const State& gradient, const State& covariance_with_gradient, double innovation,
              double variance);
  [[nodiscard]] Eigen::Vector2d lag_px() const { return state_[6] * (late_own_px_s_ + late_camera_px_s_); }
  /// The lag's derivative by the latency, times the camera's share of the motion: latency and own motion are not observable
  /// separately.
  [[nodiscard]] Eigen::Vector2d latency_gradient_px_s() const;

  State state_ = State::Zero();
  Covariance covariance_ = Covariance::Zero();
  Eigen::Vector2d carried_px_ = Eigen::Vector2d::Zero();
  // Its own and the camera's image motion, averaged over a latency.
  Eigen::Vector2d late_own_px_s_ = Eigen::Vector2d::Zero(), late_camera_px_s_ = Eigen::Vector2d::Zero();
  std::int64_t t_us_ = 0;
  std::int64_t last_edge_us_ = 0;
  bool resting_ = false;  // until the next edge
};

}  // namespace saccade
