#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "evaluation/scoring/eye_movement.h"
#include "evaluation/scoring/statistics.h"

namespace saccade {

/// What a scenario's protocol makes the ball and the body do. docs/oculomotor.md defines the figures.
struct EyeMovementProtocol {
  std::optional<double> pursuit_hz;  ///< frequency of the ball's sinusoid
  std::optional<double> sway_hz;     ///< frequency of the body's sway
};

/// Directions at one tick, deg; of the left eye. First to the right, then up.
struct EyeMovementSample {
  std::int64_t t_us = 0;
  Eigen::Vector2d gaze_deg = Eigen::Vector2d::Zero();  ///< of the optical axis, root frame
  Eigen::Vector2d ball_deg = Eigen::Vector2d::Zero();  ///< of the ball from the eye, root frame
  Eigen::Vector2d seen_deg = Eigen::Vector2d::Zero();  ///< of the ball in the camera
  Eigen::Vector2d still_deg =
      Eigen::Vector2d::Zero();  ///< the same if neck and eyes had kept their initial pose
  Eigen::Vector2d image_px =
      Eigen::Vector2d::Zero();  ///< the ball in the image; NaN where it is not in front
};

/// Output over input at one frequency.
struct Transfer {
  double frequency_hz = 0.0;
  double gain = 0.0;
  double phase_deg = 0.0;  ///< negative: the output is late
};

/// The answer of the gaze to a jump of the ball by 1 deg or more.
struct GazeStep {
  double size_deg = 0.0;
  std::optional<double> latency_ms;  ///< until the gaze turns at 20 deg/s; none: it never does
  double peak_deg_s = 0.0;           ///< highest speed over 10 ms
  std::optional<double> settled_ms;  ///< until the gaze stays within 1 deg; none: it does not within 0.7 s
};

/// Means over the middle halves of ramps, from the second ramp on.
struct GazeRamps {
  std::int64_t count = 0;
  double ball_deg_s = 0.0;
  double gain = 0.0;     ///< speed of the gaze over that of the ball
  double lag_deg = 0.0;  ///< angle from gaze to ball in the direction of motion
};

/// The figures of eye movements in metrics.json. None = does not apply.
struct EyeMovementScore {
  std::optional<Transfer> pursuit;  ///< gaze over ball
  std::optional<double> pursuit_lag_ms;
  std::optional<Transfer>
      stabilisation;  ///< counter-rotation of the gaze over the body's sway: 1, 0 deg cancels it
  std::optional<double>
      slip_reduction;     ///< 1 - motion of the ball's image over that of a head that does not move
  Percentiles error_deg;  ///< between gaze and ball; after the first 3 s, as all but the steps
  std::optional<double> image_median_px_s;  ///< motion of the ball's image over 10 ms
  std::optional<double> image_p90_px_s;
  std::vector<GazeStep> steps;  ///< by size
  std::optional<GazeRamps> ramps;
  /// Main sequence: peak speed = offset + slope * size of the saccades, least squares; three saccades or more.
  std::int64_t saccades = 0;
  std::optional<double> main_sequence_per_s;
  std::optional<double> main_sequence_offset_deg_s;
};

/// Shares of a second in which the ball's image moves at a speed, bins of `width_px_s`; the last bin is open.
struct SlipHistogram {
  static constexpr double width_px_s = 10.0;
  static constexpr std::size_t bins = 31;
  std::vector<double> shares;
};

/// Collects the samples of a run; those after the first 2^18 are left out.
class EyeMovementScorer {
 public:
  explicit EyeMovementScorer(const EyeMovementProtocol& protocol) : protocol_(protocol) {}

  /// One sample per tick of 1 ms. `axis`: the optical axis, root frame, unit length.
  void add(const EyeMovementSample& sample, const Eigen::Vector3d& axis);
  [[nodiscard]] EyeMovementScore score() const;

 private:
  EyeMovementProtocol protocol_;
  std::vector<EyeMovementSample> samples_;
  SaccadeFinder finder_;
  std::vector<Saccade> saccades_;
};

/// Azimuth (right) and elevation (up) of a direction in the root frame, deg.
[[nodiscard]] Eigen::Vector2d direction_deg(const Eigen::Vector3d& direction);
/// The same of a point in a camera's frame.
[[nodiscard]] Eigen::Vector2d direction_in_camera_deg(const Eigen::Vector3d& point);

/// Speeds of an image point over 10 ms, px/s, from `from_us` on; image points every millisecond, gaps are left out.
[[nodiscard]] std::vector<double> image_speeds_px_s(const std::vector<std::int64_t>& t_us,
                                                    const std::vector<Eigen::Vector2d>& image_px,
                                                    std::int64_t from_us);
[[nodiscard]] SlipHistogram slip_histogram(const std::vector<double>& speeds_px_s);

/// Time of a run from its start after which eye movements are scored.
inline constexpr std::int64_t eye_movements_settled_us = 3'000'000;

}  // namespace saccade
