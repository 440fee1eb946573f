#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "control/head_kinematics.h"
#include "core/units.h"

namespace saccade {

/// The points that a head looks at while it searches a lost ball: first around the place where the ball was seen last,
/// then around the direction out of the chest, and so on in turn. Each `place` is one point of a fixed pattern.
class SearchScan {
 public:
  static constexpr double distance_m = 0.5;  ///< of the points from the base of the neck

  /// `last_m`: where the ball was seen last, root frame.
  explicit SearchScan(const Eigen::Vector3d& last_m) : last_m_(last_m) {}

  /// The point number `place`, 0 and up; root frame, m.
  [[nodiscard]] Eigen::Vector3d point(std::int64_t place, const HeadKinematics& head) const {
    constexpr double side = 14.0, rise = 9.0;  // deg; the image is 65 deg wide
    constexpr std::array<std::array<double, 2>, 9> pattern = {{{0.0, 0.0},
                                                               {side, 0.0},
                                                               {-side, 0.0},
                                                               {-side, rise},
                                                               {side, rise},
                                                               {side, -rise},
                                                               {-side, -rise},
                                                               {-2 * side, 0.0},
                                                               {2 * side, 0.0}}};
    const auto count = static_cast<std::int64_t>(pattern.size());
    const bool around_last = place / count % 2 == 0;
    const auto& offset = pattern[static_cast<std::size_t>(place % count)];
    const Eigen::Vector3d neck_m = head.neck_base_m();
    const Eigen::Vector3d eye_m = head.root_from_eye(Eye::left).translation();
    const Eigen::Vector3d ahead = around_last ? Eigen::Vector3d(last_m_ - eye_m) : head.chest_forward();
    const double azimuth = std::atan2(ahead.y(), -ahead.x()) + offset[0] * rad_per_deg;
    const double elevation =
        std::atan2(ahead.z(), std::hypot(ahead.x(), ahead.y())) + offset[1] * rad_per_deg;
    const Eigen::Vector3d direction(-std::cos(azimuth) * std::cos(elevation),
                                    std::sin(azimuth) * std::cos(elevation), std::sin(elevation));
    return Eigen::Vector3d(neck_m.x(), neck_m.y(), eye_m.z()) + distance_m * direction;
  }

 private:
  Eigen::Vector3d last_m_;
};

}  // namespace saccade
