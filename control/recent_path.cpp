#include "control/recent_path.h"

#include <algorithm>
#include <cmath>

namespace saccade {

bool RecentPath::observe(double t_s, const Eigen::Vector3d& point_m, const Eigen::Vector3d& velocity_m_s) {
  const auto number = static_cast<std::int64_t>(std::floor(t_s / spacing_s));
  const bool closes = number != open_ && open_ >= 0;
  if (closes) close();
  if (open_ < 0) first_ = number;
  open_ = number;
  sum_m_ += point_m + velocity_m_s * (time_s(number) - t_s);
  ++count_;
  return closes;
}

void RecentPath::close() {
  for (std::int64_t missing = std::max(newest_ + 1, open_ - capacity); missing < open_; ++missing) {
    if (missing >= 0) averages_[static_cast<std::size_t>(missing % capacity)].known = false;
  }
  averages_[static_cast<std::size_t>(open_ % capacity)] = {sum_m_ / count_, true};
  newest_ = open_;
  sum_m_.setZero();
  count_ = 0;
}

void RecentPath::clear() {
  for (Average& average : averages_) average.known = false;
  newest_ = open_ = -1;
  count_ = 0;
  sum_m_.setZero();
}

std::int64_t RecentPath::length() const { return newest_ < 0 ? 0 : std::min(capacity, newest_ - first_ + 1); }

}  // namespace saccade
