#include "control/straight_path.h"

#include <algorithm>

namespace saccade {
namespace {

constexpr std::int64_t first_back = 5, last_back = 30;  // averages: 0.1 to 0.6 s
constexpr int fewest = 10;
constexpr double most_distance_m = 0.008;
constexpr double noise_m_s = 0.03;  // of a fitted velocity: errors of targets, a hand that sways
constexpr double fastest_m_s = 0.2;

}  // namespace

std::optional<StraightPath> fit_straight_path(const RecentPath& path) {
  const std::int64_t oldest = std::min(last_back, path.length() - 1);
  const auto for_each = [&](auto f) {
    for (std::int64_t back = first_back; back <= oldest; ++back) {
      if (path.at(back).known) f(-static_cast<double>(back) * RecentPath::spacing_s, path.at(back).point_m);
    }
  };
  int count = 0;
  double mean_s = 0.0;
  Eigen::Vector3d mean_m = Eigen::Vector3d::Zero();
  for_each([&](double t_s, const Eigen::Vector3d& point_m) {
    ++count;
    mean_s += t_s;
    mean_m += point_m;
  });
  if (count < fewest) return std::nullopt;
  mean_s /= count;
  mean_m /= count;
  double squares = 0.0;
  Eigen::Vector3d products = Eigen::Vector3d::Zero();
  for_each([&](double t_s, const Eigen::Vector3d& point_m) {
    squares += (t_s - mean_s) * (t_s - mean_s);
    products += (t_s - mean_s) * (point_m - mean_m);
  });
  Eigen::Vector3d velocity = products / squares;
  velocity.x() = 0.0;
  double distances_m2 = 0.0;
  for_each([&](double t_s, const Eigen::Vector3d& point_m) {
    distances_m2 += (point_m - mean_m - (t_s - mean_s) * velocity).tail<2>().squaredNorm() / count;
  });
  if (distances_m2 > most_distance_m * most_distance_m || velocity.norm() > fastest_m_s) return std::nullopt;
  const double speed2 = velocity.squaredNorm();
  velocity *= speed2 / (speed2 + noise_m_s * noise_m_s);
  return StraightPath{RecentPath::time_s(path.newest()) + mean_s, mean_m, velocity};
}

}  // namespace saccade
