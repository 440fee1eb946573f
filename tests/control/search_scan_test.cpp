#include "control/search_scan.h"

#include <gtest/gtest.h>

#include "control/locating_gate.h"
#include "core/units.h"
#include "head/icub_cameras.h"

namespace saccade {
namespace {

double angle_deg(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::acos(std::clamp(a.normalized().dot(b.normalized()), -1.0, 1.0)) * deg_per_rad;
}

TEST(SearchScan, LooksAroundTheLastPlaceAndThenAhead) {
  const HeadKinematics head(default_head()->chain, JointVector::Zero());
  const Eigen::Vector3d eye_m = head.root_from_eye(Eye::left).translation();
  const Eigen::Vector3d last_m = eye_m + Eigen::Vector3d(-0.4, 0.25, -0.1);
  const SearchScan scan(last_m);
  const Eigen::Vector3d base_m(head.neck_base_m().x(), head.neck_base_m().y(), eye_m.z());
  const auto direction = [&](std::int64_t place) {
    return Eigen::Vector3d(scan.point(place, head) - base_m);
  };
  EXPECT_LT(angle_deg(direction(0), last_m - eye_m), 1e-6);
  EXPECT_LT(angle_deg(direction(9), head.chest_forward()), 1e-6);
  EXPECT_LT(angle_deg(direction(18), direction(0)), 1e-6) << "in turn";
  for (std::int64_t place = 0; place < 18; ++place) {
    EXPECT_NEAR(direction(place).norm(), SearchScan::distance_m, 1e-9) << place;
    EXPECT_LT(angle_deg(direction(place), direction(place < 9 ? 0 : 9)), 30.0) << place;
  }
}

/// The gate of a plain locator.
class PlainGate final : public LocatingGate {
 public:
  using LocatingGate::LocatingGate;
  std::optional<Eigen::Vector3d> update(std::int64_t, const Estimate& estimate, double threshold,
                                        const Camera& camera,
                                        const Eigen::Isometry3d& root_from_cam) override {
    if (!is_detection(estimate, threshold)) return std::nullopt;
    return locate(estimate.circle, camera, root_from_cam);
  }
};

TEST(LocatingGate, CountsTheCirclesThatGiveNoTarget) {
  PlainGate gate{TargetConfig{}};
  Eigen::Isometry3d ahead = Eigen::Isometry3d::Identity();
  ahead.linear() << 0, 0, -1, 1, 0, 0, 0, -1, 0;
  const auto update = [&](const Circle& circle, double score) {
    return gate.update(0, {true, false, circle, score}, 0.5, icub_left_2016, ahead);
  };
  EXPECT_TRUE(update({64, 64, 12}, 0.5));
  EXPECT_FALSE(update({64, 64, 12}, 0.49)) << "below the threshold";
  EXPECT_FALSE(update({64, 64, 12}, std::nan("")));
  EXPECT_EQ(gate.rejected().not_finite + gate.rejected().bad_radius, 0);
  EXPECT_FALSE(update({std::nan(""), 64, 12}, 1.0));
  EXPECT_FALSE(update({64, 64, -1}, 1.0));
  EXPECT_EQ(gate.rejected().not_finite, 1);
  EXPECT_EQ(gate.rejected().bad_radius, 1);
}

}  // namespace
}  // namespace saccade
