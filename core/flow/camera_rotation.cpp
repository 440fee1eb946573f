#include "core/flow/camera_rotation.h"

#include <bit>
#include <cstddef>

#include "core/flow/plane_fit_flow.h"
#include "core/small_solve.h"

namespace saccade {
namespace {

constexpr int rotation_passes = 4;        // of the reweighted fit, which starts from the last rotation
constexpr double agree_sd2 = 2.0;         // squared deviations of the flow within which an edge agrees
constexpr double least_agreeing = 0.5;    // share of the edges
constexpr std::size_t fewest_flows = 50;  // three unknowns with many outliers; chosen
constexpr int cells = 4;                  // the image in cells x cells parts
constexpr int fewest_cells = 9;           // of them with edges that agree

}  // namespace

Eigen::Vector3d camera_rotation(std::span<const FlowSample> flows, const Camera& camera,
                                std::span<const Eigen::Vector3d> rays, const Eigen::Vector3d& start) {
  if (flows.size() <= fewest_flows) return Eigen::Vector3d::Zero();
  Eigen::Vector3d rotation = start;
  std::uint32_t seen = 0;
  double agreeing = 0.0;
  for (int pass = 0; pass < rotation_passes; ++pass) {
    Eigen::Matrix3d normal = 1e-3 * Eigen::Matrix3d::Identity();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    seen = 0;
    agreeing = 0.0;
    for (const FlowSample& flow : flows) {
      const Eigen::Vector3d& ray = rays[static_cast<std::size_t>(flow.y * camera.size.width + flow.x)];
      Eigen::Vector3d gradient;
      for (int axis = 0; axis < 3; ++axis)
        gradient[axis] = flow.along.dot(camera.rotational_flow_px_s(ray, Eigen::Vector3d::Unit(axis)));
      const double sd = flow_sd_px_s(flow.speed_px_s);
      const double z = (flow.speed_px_s - rotation.dot(gradient)) / sd;
      const double weight = 1.0 / (sd * sd * (1.0 + z * z) * (1.0 + z * z));
      normal += weight * gradient * gradient.transpose();
      right += weight * flow.speed_px_s * gradient;
      if (z * z >= agree_sd2) continue;
      agreeing += 1.0;
      const int cell = flow.y * cells / camera.size.height * cells + flow.x * cells / camera.size.width;
      seen |= 1U << static_cast<unsigned>(cell);
    }
    rotation = ldlt_solution(normal, right);
  }
  const bool most =
      agreeing > least_agreeing * static_cast<double>(flows.size()) && std::popcount(seen) >= fewest_cells;
  return most ? rotation : Eigen::Vector3d::Zero();
}

}  // namespace saccade
