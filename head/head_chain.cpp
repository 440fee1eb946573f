#include "head/head_chain.h"

#include <cmath>
#include "core/units.h"

namespace saccade {
namespace {

/// Sine of an angle, exact for multiples of 90 deg.
double sine(double deg) {
  const double quarters = deg / 90.0;
  if (quarters != std::round(quarters)) return std::sin(deg * rad_per_deg);
  constexpr std::array<double, 4> values = {0.0, 1.0, 0.0, -1.0};
  const double turn = std::fmod(std::fmod(quarters, 4.0) + 4.0, 4.0);
  return values[static_cast<std::size_t>(turn)];
}

/// A unit vector whose elements lost what rounding made of 0, 1 and -1.
Eigen::Vector3d snapped(Eigen::Vector3d v) {
  for (double& element : v) {
    if (std::abs(element - std::round(element)) < 1e-9) element = std::round(element);
  }
  return v;
}

}  // namespace

ChainLink ChainLink::dh(double a_m, double d_m, double alpha_deg, double offset_deg) {
  ChainLink link;
  link.a_m = a_m;
  link.d_m = d_m;
  link.sin_alpha = sine(alpha_deg);
  link.cos_alpha = sine(alpha_deg + 90.0);
  link.offset_rad = offset_deg * rad_per_deg;
  return link;
}

ChainLink ChainLink::named(std::string hinge) const {
  ChainLink link = *this;
  link.name = std::move(hinge);
  return link;
}

ChainLink ChainLink::turned_by(int slot, double share) const {
  ChainLink link = *this;
  link.turns.at(static_cast<std::size_t>(link.joints)) = {slot, share};
  ++link.joints;
  return link;
}

ChainLink ChainLink::after(const Eigen::Isometry3d& pose) const {
  ChainLink link = *this;
  link.before = pose;
  link.has_before = true;
  return link;
}

void apply_turn(const ChainLink& link, double angle_rad, Eigen::Isometry3d& frame) {
  const double c = std::cos(angle_rad + link.offset_rad);
  const double s = std::sin(angle_rad + link.offset_rad);
  // Zeros stay zeros without a sign.
  const bool quarter = link.cos_alpha == 0.0;
  const bool straight = link.sin_alpha == 0.0;
  Eigen::Isometry3d t;
  t.matrix() << c, quarter ? 0.0 : -s * link.cos_alpha, straight ? 0.0 : s * link.sin_alpha, link.a_m * c,  //
      s, quarter ? 0.0 : c * link.cos_alpha, straight ? 0.0 : -c * link.sin_alpha, link.a_m * s,            //
      0.0, link.sin_alpha, link.cos_alpha, link.d_m,                                                        //
      0.0, 0.0, 0.0, 1.0;
  frame = frame * t;
}

void HeadChain::complete() {
  torso_links = 0;
  while (torso_links < common.size()) {
    const ChainLink& link = common[torso_links];
    bool of_gaze = false;
    for (int i = 0; i < link.joints; ++i)
      of_gaze = of_gaze || link.turns[static_cast<std::size_t>(i)].slot >= torso_slots;
    if (of_gaze) break;
    ++torso_links;
  }
  // Fixed links after the torso's last joint belong to the neck.
  while (torso_links > 0 && !common[torso_links - 1].moves()) --torso_links;
  const JointVector zero = JointVector::Zero();
  Eigen::Isometry3d frame = root_from_base;
  const auto pass = [&](const ChainLink& link) {
    apply_before(link, frame);
    apply_turn(link, link.angle_rad(zero), frame);
  };
  for (std::size_t i = 0; i < torso_links; ++i) pass(common[i]);
  const Eigen::Matrix3d chest_from_root = frame.linear().transpose();
  const Eigen::Isometry3d root_from_eye = hinges_at_zero(*this).root_from_eye[0];
  chest_right = snapped(chest_from_root * root_from_eye.linear().col(0));
  chest_up = snapped(chest_from_root * -root_from_eye.linear().col(1));
}

Hinges hinges_at_zero(const HeadChain& chain) {
  const JointVector zero = JointVector::Zero();
  Hinges found;
  const auto pass = [&](const ChainLink& link, std::size_t parent, Eigen::Isometry3d& frame) {
    apply_before(link, frame);
    if (link.moves()) {
      found.hinges.push_back({&link, parent, frame.translation(), frame.linear().col(2)});
      parent = found.hinges.size() - 1;
    }
    apply_turn(link, link.angle_rad(zero), frame);
    return parent;
  };
  Eigen::Isometry3d frame = chain.root_from_base;
  std::size_t last = Hinge::none;
  for (const ChainLink& link : chain.common) last = pass(link, last, frame);
  for (std::size_t e = 0; e < static_cast<std::size_t>(chain.eyes); ++e) {
    Eigen::Isometry3d eye = frame;
    found.last[e] = last;
    for (const ChainLink& link : chain.eye[e]) found.last[e] = pass(link, found.last[e], eye);
    found.root_from_eye[e] = chain.has_eye_from_last ? eye * chain.eye_from_last[e] : eye;
  }
  if (chain.eyes == 1) {
    found.last[1] = found.last[0];
    found.root_from_eye[1] = found.root_from_eye[0];
  }
  return found;
}

}  // namespace saccade
