#pragma once

#include <Eigen/Geometry>
#include <vector>

namespace saccade {

/// An object's pose at an instant.
struct MotionSample {
  double t_s = 0.0;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();      ///< of its centre, root frame
  Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();  ///< root from object
};

/// A motion through samples in time. Between two samples the position is a cubic with continuous velocity (the slope at
/// a sample is that of the parabola through it and its neighbours), the orientation turns evenly on the shorter way.
/// Before the first sample and after the last the object rests.
class MotionTrack {
 public:
  /// At least one sample, at increasing times.
  explicit MotionTrack(std::vector<MotionSample> samples);

  [[nodiscard]] Eigen::Vector3d position_m(double t_s) const;
  [[nodiscard]] Eigen::Quaterniond turn(double t_s) const;
  [[nodiscard]] const std::vector<MotionSample>& samples() const { return samples_; }

 private:
  /// Index of the sample at or before t_s; times are inside the track.
  [[nodiscard]] std::size_t before(double t_s) const;

  std::vector<MotionSample> samples_;
  std::vector<Eigen::Vector3d> velocity_m_s_;  ///< at the samples
};

}  // namespace saccade
