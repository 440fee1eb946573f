#pragma once

#include <string>

#include "head/head_description.h"

namespace saccade {

/// The description of a head from iKin's lists of links (iKinLimb::fromLinksProperties), one for each eye:
///
///     type left
///     H0 (0.0 -1.0 0.0 0.0  ... 16 numbers by rows)
///     HN (...)
///     numLinks 8
///     link_0 (A 0.032) (D 0.0) (alpha 90.0) (offset 0.0) (min -22.0) (max 84.0)
///
/// or each link as a group [link_0] with a line for each key. Lengths are in m, angles in deg; `blocked` fixes a link. What
/// is missing is 0, H0 and HN the identity. Comments begin with # or //.
///
/// `left` and `right` are texts of such files, under their names in messages; without a right one the head has one eye. Rows
/// that are the same in both belong to the neck; a row that differs in D alone is one hinge with the eyes beside it, the
/// tilt of the iCub. The joints are named and assigned as those of an iCub where there are eight links, otherwise by their
/// links, the last two those of the eyes. With two eyes the last link is turned by version and vergence. Throws InputError.
struct IkinText {
  std::string name;
  std::string text;
};
[[nodiscard]] HeadDescription description_of_ikin(const IkinText& left, const IkinText* right);

}  // namespace saccade
