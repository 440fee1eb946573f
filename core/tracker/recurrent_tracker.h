#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "core/detector_parts.h"
#include "core/detector_views.h"
#include "core/tracker/recurrent_network.h"

namespace saccade {

/// Configuration of the detector `recurrent`.
struct RecurrentTrackerConfig {
  std::array<double, 2> radius_px = {10, 35};  ///< smallest and largest radius, whole numbers
  double threshold = 0.5;  ///< existence probability from which on a circle is taken for the ball
  double hold_s = 3.0;     ///< a circle that is not measured is held for so long
  ModelFile model;         ///< the network's weights
};

/// Keys: radius_px, threshold, hold_s, model.
void describe(FieldVisitor& v, RecurrentTrackerConfig& config);

/// Follows up to eight circles that the recurrent network finds, each with a Kalman filter, and returns the one that most
/// probably exists.
///
/// State of a circle: centre, radius, and the centre's speed beside the image motion that the camera's rotation makes. Each of
/// the network's steps gives at most one measurement of each circle. The existence log odds are a running mean of those that
/// the network gives the circle.
class RecurrentTracker final : public Detector, public DetectorViews {
 public:
  /// Throws InputError for a configuration out of range.
  RecurrentTracker(const RecurrentTrackerConfig& config, const Camera& camera);

  void process(std::span<const Event> events, const CameraMotion* motion) override;
  void advance_to(std::int64_t now_us, const CameraMotion* motion) override;
  [[nodiscard]] Estimate estimate() override;
  [[nodiscard]] double threshold() const override { return config_.threshold; }
  [[nodiscard]] RejectedEvents rejected() const override { return sieve_.rejected(); }
  [[nodiscard]] std::unique_ptr<Detector> copy() const override {
    return std::make_unique<RecurrentTracker>(*this);
  }

 private:
  using State = Eigen::Matrix<double, 5, 1>;  // x, y, r, vx, vy
  using Covariance = Eigen::Matrix<double, 5, 5>;
  struct Track {
    bool alive = false;
    State state;
    Covariance covariance;
    Eigen::Vector2d camera_px_s;  // image motion at it by the camera's rotation
    double log_odds = 0.0;        // that it is the ball
    std::int64_t measured_us = 0;
    bool taken = false;  // by a measurement of this step
  };

  void set_motion(const CameraMotion* motion);
  [[nodiscard]] Eigen::Vector2d camera_flow_px_s(const Eigen::Vector2d& at_px) const;
  void run_until(std::int64_t t_us, bool inclusive);
  void tick(std::int64_t now_us);
  void predict(Track& track, double dt_s);
  void take_found(std::int64_t now_us);
  void measure(Track& track, const RecurrentNetwork::Found& found, double late_s) const;
  void begin_track(const RecurrentNetwork::Found& found, double late_s, std::int64_t now_us);
  [[nodiscard]] const Track* best() const;

  RecurrentTrackerConfig config_;
  Camera camera_;
  std::vector<Eigen::Vector3d> rays_;  // of each pixel
  EventSieve sieve_;
  TimeSurface surface_;
  RecurrentNetwork network_;
  std::array<Track, 8> tracks_;
  std::optional<Eigen::Vector3d> rotation_rad_s_;             // of the camera, its own frame
  Eigen::Vector2d image_shift_px_ = Eigen::Vector2d::Zero();  // of the image's middle since the step began
  bool rotation_known_ = false;                               // in all of that time
  std::int64_t now_us_, step_us_;
  std::optional<std::int64_t> next_tick_us_;
};

}  // namespace saccade
