#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "core/detector_parts.h"
#include "core/detector_views.h"
#include "core/reserved_vector.h"

namespace saccade {

/// Event blob tracker (Wang, Molloy, van Goor and Mahony, "Asynchronous Blob Tracker for Event Cameras", IEEE
/// Transactions on Robotics 40, 2024). The defaults of the noise are those of the authors' configuration for 240 x 180
/// pixels.
struct BlobFilterConfig {
  std::array<double, 2> radius_px = {10, 35};  ///< smallest and largest radius
  std::int64_t blobs = 8;                      ///< most at a time
  double reach = 2.5;                          ///< an event this near is the blob's, standard deviations
  double least_reach_px = 10.0;                ///< and one this near
  double position_noise_px2_s = 500.0;         ///< growth of the variance of a centre's coordinate
  double velocity_noise_px2_s3 = 5000.0;       ///< growth of the variance of a velocity
  double size_noise_px2_s = 0.01;              ///< growth of the variance of a standard deviation
  double decay_us = 20'000;                    ///< time constant of support
  double threshold = 1.0;                      ///< support, in events per px of outline, taken for the ball
};

/// Keys: radius_px, blobs, reach, least_reach_px, position_noise_px2_s, velocity_noise_px2_s3, size_noise_px2_s, decay_us,
/// threshold.
void describe(FieldVisitor& v, BlobFilterConfig& config);

/// Extended Kalman filters of blobs of events, event by event.
///
/// The events of a blob are normally distributed around its centre p with standard deviation s in each direction. With
/// chi = (event - p) / s an event is two measurements: chi = 0 with variance 1 in each coordinate, and the sum of |chi|^2
/// over the 10 events before it, 2 n with variance 4 n. The state is p, its velocity, and s. An event belongs to the
/// nearest blob within its reach.
///
/// Of the original the ellipse, its rotation and the distance between ON and OFF events are left out. The original is
/// given the first centres and sizes. Here an event without a blob starts one of middle size, support decays as in
/// `cluster`, and of two blobs nearer than s the one with less support ends. The events of a circle's outline have
/// s = r / sqrt(2) in each coordinate: the estimate is the circle of radius sqrt(2) s around the blob with the largest
/// score.
///
/// Score: support over the length of the outline, events per px; any number from 0 on.
class BlobFilter final : public Detector, public DetectorViews {
 public:
  /// Throws InputError for a configuration out of range.
  BlobFilter(const BlobFilterConfig& config, ImageSize size);

  void process(std::span<const Event> events, const CameraMotion* motion) override;
  void advance_to(std::int64_t now_us, const CameraMotion* motion) override;
  [[nodiscard]] Estimate estimate() override;
  [[nodiscard]] double threshold() const override { return config_.threshold; }
  [[nodiscard]] RejectedEvents rejected() const override { return sieve_.rejected(); }
  [[nodiscard]] std::unique_ptr<Detector> copy() const override {
    return std::make_unique<BlobFilter>(*this);
  }

 private:
  static constexpr std::size_t history = 10;  // events of the measurement of size
  using State = Eigen::Matrix<double, 5, 1>;  // x, y, their velocities, s
  struct Blob {
    State state = State::Zero();
    Eigen::Matrix<double, 5, 5> covariance = Eigen::Matrix<double, 5, 5>::Zero();
    std::array<double, history> distance2_px2{};  // of the newest events from the centre, a ring
    std::size_t events = 0;
    double support = 0.0;  // at last_us
    std::int64_t last_us = 0;
    [[nodiscard]] double deviation_px() const { return state[4]; }
  };
  [[nodiscard]] double support(const Blob& blob, std::int64_t now_us) const;
  [[nodiscard]] double reach_px(const Blob& blob) const;
  void take(const Event& event);
  void start(const Event& event);
  void predict(Blob& blob, std::int64_t t_us) const;
  void update(Blob& blob, const Event& event) const;
  void remove_rivals(std::size_t index);

  BlobFilterConfig config_;
  EventSieve sieve_;
  ReservedVector<Blob> blobs_;
  std::int64_t now_us_;
};

}  // namespace saccade
