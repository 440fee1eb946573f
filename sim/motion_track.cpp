#include "sim/motion_track.h"

#include <algorithm>

#include "core/error.h"

namespace saccade {

using Eigen::Quaterniond;
using Eigen::Vector3d;

MotionTrack::MotionTrack(std::vector<MotionSample> samples) : samples_(std::move(samples)) {
  SACCADE_CHECK(!samples_.empty());
  const std::size_t count = samples_.size();
  velocity_m_s_.assign(count, Vector3d::Zero());
  if (count == 1) return;
  const auto slope = [this](std::size_t i) -> Vector3d {  // from sample i to the next
    return (samples_[i + 1].position_m - samples_[i].position_m) / (samples_[i + 1].t_s - samples_[i].t_s);
  };
  velocity_m_s_.front() = slope(0);
  velocity_m_s_.back() = slope(count - 2);
  for (std::size_t i = 1; i + 1 < count; ++i) {
    const double before_s = samples_[i].t_s - samples_[i - 1].t_s;
    const double after_s = samples_[i + 1].t_s - samples_[i].t_s;
    velocity_m_s_[i] = (after_s * slope(i - 1) + before_s * slope(i)) / (before_s + after_s);
  }
}

std::size_t MotionTrack::before(double t_s) const {
  const auto next = std::upper_bound(samples_.begin(), samples_.end(), t_s,
                                     [](double t, const MotionSample& sample) { return t < sample.t_s; });
  return static_cast<std::size_t>(next - samples_.begin()) - 1;
}

Vector3d MotionTrack::position_m(double t_s) const {
  if (t_s <= samples_.front().t_s) return samples_.front().position_m;
  if (t_s >= samples_.back().t_s) return samples_.back().position_m;
  const std::size_t i = before(t_s);
  const MotionSample& from = samples_[i];
  const MotionSample& to = samples_[i + 1];
  const double length_s = to.t_s - from.t_s;
  const double u = (t_s - from.t_s) / length_s;
  const double end = u * u * (3.0 - 2.0 * u);
  return (1.0 - end) * from.position_m + end * to.position_m +
         length_s * (u * (1.0 - u) * (1.0 - u) * velocity_m_s_[i] + u * u * (u - 1.0) * velocity_m_s_[i + 1]);
}

Quaterniond MotionTrack::turn(double t_s) const {
  if (t_s <= samples_.front().t_s) return samples_.front().turn;
  if (t_s >= samples_.back().t_s) return samples_.back().turn;
  const MotionSample& from = samples_[before(t_s)];
  const MotionSample& to = samples_[before(t_s) + 1];
  return from.turn.slerp((t_s - from.t_s) / (to.t_s - from.t_s), to.turn);
}

}  // namespace saccade
