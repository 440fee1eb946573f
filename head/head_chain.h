#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "head/head_state.h"

namespace saccade {

enum class Eye : int { left, right };

/// How far a link turns per rotation of a joint.
struct JointShare {
  int slot = 0;  ///< of the joint, in a JointVector
  double share = 1.0;
};

/// One link of a head's kinematic chain: a fixed pose, then a row of a DH table,
///
///     H = before * Rz(q + offset) Tz(d) Tx(a) Rx(alpha).
///
/// q is the sum of the joints that turn the link, each times its share; a link without joints is fixed (q = 0). The axis
/// of the link is the z axis of the frame after `before`.
struct ChainLink {
  std::string name;  ///< of the hinge in a simulator's model; empty for a fixed link
  double a_m = 0.0;
  double d_m = 0.0;
  double sin_alpha = 0.0;  ///< exact for multiples of 90 deg; see ChainLink::dh
  double cos_alpha = 1.0;
  double offset_rad = 0.0;
  std::array<JointShare, 2> turns{};
  int joints = 0;  ///< how many of `turns` are used
  bool has_before = false;
  Eigen::Isometry3d before = Eigen::Isometry3d::Identity();

  /// A row of a DH table, angles in deg. Sine and cosine of multiples of 90 deg are exact.
  [[nodiscard]] static ChainLink dh(double a_m, double d_m, double alpha_deg, double offset_deg);
  /// The same link with the name of its hinge.
  [[nodiscard]] ChainLink named(std::string hinge) const;
  /// The same link turned by a joint, or by one more.
  [[nodiscard]] ChainLink turned_by(int slot, double share = 1.0) const;
  /// The same link with a fixed pose before it.
  [[nodiscard]] ChainLink after(const Eigen::Isometry3d& pose) const;

  [[nodiscard]] bool moves() const { return joints > 0; }
  [[nodiscard]] double angle_rad(const JointVector& position_rad) const {
    double angle = 0.0;
    if (joints > 0) angle = turns[0].share * position_rad[turns[0].slot];
    if (joints > 1) angle += turns[1].share * position_rad[turns[1].slot];
    return angle;
  }
};

/// The kinematic chain of a head: from the root over torso and neck to where the eyes branch off, then to each eye. Does
/// not change after it was made; reading it allocates nothing.
///
/// Frames: root as in docs/conventions.md; the frame of an eye has the axes of an OpenCV camera: z along the optical axis, x right,
/// y down.
struct HeadChain {
  static constexpr std::size_t max_common_links = 24;
  static constexpr std::size_t max_eye_links = 8;  ///< of each eye

  Eigen::Isometry3d root_from_base = Eigen::Isometry3d::Identity();
  std::vector<ChainLink> common;
  std::array<std::vector<ChainLink>, 2> eye;  ///< left, right; the right one is not used with one eye
  /// The eye's frame in the frame after its last link.
  std::array<Eigen::Isometry3d, 2> eye_from_last = {Eigen::Isometry3d::Identity(),
                                                    Eigen::Isometry3d::Identity()};
  bool has_eye_from_last = false;
  int eyes = 2;

  // What follows from the links; set by complete().
  std::size_t torso_links = 0;  ///< links before the first one that a joint of the gaze turns
  Eigen::Vector3d chest_right =
      Eigen::Vector3d::UnitZ();  ///< right and up with all joints at 0, in the frame of
  Eigen::Vector3d chest_up = Eigen::Vector3d::UnitY();  ///< the chest: that after the torso's links

  /// Computes what follows from the links.
  void complete();
  [[nodiscard]] bool has(Eye which) const { return which == Eye::left || eyes > 1; }
};

/// Multiplies `frame`, root from the frame before a link, with the link's fixed pose: z is then the link's axis.
inline void apply_before(const ChainLink& link, Eigen::Isometry3d& frame) {
  if (link.has_before) frame = frame * link.before;
}
/// Multiplies `frame`, after apply_before(), with the link turned by `angle_rad`.
void apply_turn(const ChainLink& link, double angle_rad, Eigen::Isometry3d& frame);

/// A link that joints turn, with the chain at one position: a hinge of a plant.
struct Hinge {
  static constexpr std::size_t none = ~std::size_t{0};
  const ChainLink* link = nullptr;
  std::size_t parent = none;  ///< index of the hinge before it; none: the root carries it
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero();  ///< on the axis, root
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();    ///< root
};

/// The hinges of a chain with all joints at 0: those of the common links, then those of the left eye, then the right eye's.
/// `last[e]`: the index of the hinge that carries eye e, or Hinge::none. `root_from_eye`: the eyes.
struct Hinges {
  std::vector<Hinge> hinges;
  std::array<std::size_t, 2> last = {Hinge::none, Hinge::none};
  std::array<Eigen::Isometry3d, 2> root_from_eye{};
};
[[nodiscard]] Hinges hinges_at_zero(const HeadChain& chain);

}  // namespace saccade
