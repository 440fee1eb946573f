#include "control/free_fall.h"

#include <cmath>

namespace saccade {
namespace {

constexpr int averages = 7;  // the polynomials below are for seven
constexpr double most_acceleration_error_m_s2 = 2.5;
constexpr double most_jerk_m_s3 = 70.0;  // a ball on a circle of 7 cm at 2 Hz: 139
constexpr double most_distance_m = 0.004;

}  // namespace

std::optional<FreeFall> fit_free_fall(const RecentPath& path) {
  if (path.length() < averages) return std::nullopt;
  const double spacing_s = RecentPath::spacing_s;
  // Times from the middle one: sums of odd powers are 0.
  constexpr int half = averages / 2;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero(), slope = mean, bend = mean, twist = mean;
  double squares = 0.0, bends = 0.0;
  constexpr double mean_square = half * (half + 1) / 3.0;  // of -half ... half
  for (int k = -half; k <= half; ++k) {
    const RecentPath::Average& average = path.at(half - k);
    if (!average.known) return std::nullopt;
    const double curve = k * k - mean_square;
    mean += average.point_m / averages;
    slope += k * average.point_m;
    bend += curve * average.point_m;
    twist +=
        (k * k - 7.0) * k / 6.0 * average.point_m;  // orthogonal polynomial of third order for seven points
    squares += k * k;
    bends += curve * curve;
  }
  slope /= squares * spacing_s;
  const Eigen::Vector3d acceleration = 2.0 * bend / (bends * spacing_s * spacing_s);
  if ((acceleration - gravity_m_s2()).tail<2>().norm() > most_acceleration_error_m_s2) return std::nullopt;
  const Eigen::Vector3d jerk = twist / (6.0 * spacing_s * spacing_s * spacing_s);
  if (jerk.tail<2>().norm() > most_jerk_m_s3) return std::nullopt;

  const Eigen::Vector3d middle = mean - 0.5 * mean_square * spacing_s * spacing_s * gravity_m_s2();
  double distances_m2 = 0.0;
  for (int k = -half; k <= half; ++k) {
    const double t_s = k * spacing_s;
    const Eigen::Vector3d flight = middle + t_s * slope + 0.5 * t_s * t_s * gravity_m_s2();
    distances_m2 += (path.at(half - k).point_m - flight).tail<2>().squaredNorm() / averages;
  }
  if (distances_m2 > most_distance_m * most_distance_m) return std::nullopt;
  return FreeFall{RecentPath::time_s(path.newest() - half), middle, slope};
}

}  // namespace saccade
