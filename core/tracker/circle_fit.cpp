#include "core/tracker/circle_fit.h"

#include <algorithm>
#include <cmath>

#include "core/flow/plane_fit_flow.h"
#include "core/small_solve.h"
#include "core/tracker/circle_track.h"

namespace saccade {
namespace {

constexpr int fit_passes = 3;
constexpr double on_circle_px = 2.0;  // for its motion
// What the edges leave open is rest, and no growth: shares of the information in them.
constexpr double rest_share = 1e-4, no_growth_share = 0.02;
constexpr double near_share = 0.25, nearest_px = 2.5,
                 farthest_px = 4.0;  // of the radius; narrowing with each pass
constexpr double largest_step_px = 1.5, largest_growth_px = 1.0;
constexpr int fewest_edges = 5;

}  // namespace

Eigen::Vector3d CircleFit::motion(const Circle& c) const {
  Eigen::Vector3d motion = Eigen::Vector3d::Zero();
  for (int pass = 0; pass < fit_passes; ++pass) {
    Eigen::Matrix3d normal = 1e-12 * Eigen::Matrix3d::Identity();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (const Sample& edge : edges_) {
      const Eigen::Vector2d at = edge.now_px - Eigen::Vector2d(c.x_px, c.y_px);
      const double distance = at.norm();
      if (std::abs(distance - c.r_px) > on_circle_px) continue;
      const double cosine = edge.along.dot(at) / std::max(distance, 1e-3);
      if (std::abs(cosine) < CircleTrack::min_alignment) continue;
      const Eigen::Vector3d gradient(edge.along.x(), edge.along.y(), cosine);
      const double sd = flow_sd_px_s(edge.speed_px_s);
      double weight = 1.0 / (sd * sd);
      if (pass > 0) {
        const double z = (edge.speed_px_s - motion.dot(gradient)) / sd;
        weight /= 1.0 + z * z;
      }
      normal += weight * gradient * gradient.transpose();
      right += weight * edge.speed_px_s * gradient;
    }
    normal += normal.trace() * Eigen::Vector3d(rest_share, rest_share, no_growth_share).asDiagonal();
    motion = ldlt_solution(normal, right);
  }
  return motion;
}

Circle CircleFit::place(Circle c, const Eigen::Vector3d& motion_px_s, double r_min_px,
                        double r_max_px) const {
  double near_px = std::clamp(near_share * c.r_px, nearest_px, farthest_px);
  for (int pass = 0; pass < fit_passes; ++pass) {
    Eigen::Matrix3d normal = 0.5 * Eigen::Matrix3d::Identity();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    int used = 0;
    for (const Sample& edge : edges_) {
      const Eigen::Vector2d offset =
          edge.at_px + motion_px_s.head<2>() * edge.age_s - Eigen::Vector2d(c.x_px, c.y_px);
      const double distance = offset.norm();
      const double off_px = distance + motion_px_s.z() * edge.age_s - c.r_px;
      if (std::abs(off_px) > near_px || distance < 1.0 ||
          std::abs(edge.along.dot(offset)) < CircleTrack::min_alignment * distance)
        continue;
      const double share = off_px / near_px;
      const double weight = (1.0 - share * share) * (1.0 - share * share);
      const Eigen::Vector3d gradient(offset.x() / distance, offset.y() / distance, 1.0);
      normal += weight * gradient * gradient.transpose();
      right += weight * off_px * gradient;
      ++used;
    }
    if (used < fewest_edges) return c;
    const Eigen::Vector3d step = ldlt_solution(normal, right);
    c.x_px += std::clamp(step[0], -largest_step_px, largest_step_px);
    c.y_px += std::clamp(step[1], -largest_step_px, largest_step_px);
    c.r_px =
        std::clamp(c.r_px + std::clamp(step[2], -largest_growth_px, largest_growth_px), r_min_px, r_max_px);
    near_px = std::max(2.0, near_px - 0.5);
  }
  return c;
}

}  // namespace saccade
