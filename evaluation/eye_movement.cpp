#include "evaluation/eye_movement.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.h"

namespace saccade {

double angle_deg(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) * 180.0 / std::numbers::pi;
}

void SaccadeFinder::add(std::int64_t t_us, const Eigen::Vector3d& axis) {
  SACCADE_CHECK(!started_ || t_us > last_t_us_);
  if (started_) speed_deg_s_ = angle_deg(last_axis_, axis) * 1e6 / static_cast<double>(t_us - last_t_us_);
  if (started_ && speed_deg_s_ > Saccade::fast_deg_s) {
    stretch_.end_us = t_us;
    stretch_.amplitude_deg = angle_deg(start_axis_, axis);
    stretch_.peak_deg_s = std::max(stretch_.peak_deg_s, speed_deg_s_);
    if (counted_) {
      saccades_.back() = stretch_;
    } else if (stretch_.end_us - stretch_.start_us >= Saccade::shortest_us) {
      saccades_.push_back(stretch_);
      counted_ = true;
    }
  } else {
    stretch_ = {.start_us = t_us, .end_us = t_us, .amplitude_deg = 0.0, .peak_deg_s = 0.0};
    start_axis_ = axis;
    counted_ = false;
  }
  started_ = true;
  last_t_us_ = t_us;
  last_axis_ = axis;
}

}  // namespace saccade
