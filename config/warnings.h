#pragma once

#include <string>
#include <vector>

#include "config/scenario.h"

namespace saccade {

/// The implausible values of a valid scenario, one line each: a principal point outside the image, a lens whose distortion
/// moves a point of the image's border by more than a quarter of the diagonal, a ball whose radius in the image never lies
/// in a detector's radius_px (distances from the left eye at the initial pose). Empty for a plausible scenario.
[[nodiscard]] std::vector<std::string> warnings_of(const Scenario& scenario);

}  // namespace saccade
