#include "core/detector_parts.h"

#include <cmath>

#include "core/error.h"

namespace saccade {

void describe_radius_px(FieldVisitor& v, std::array<double, 2>& r) {
  v.reals("radius_px", r, {1, 255}, "smallest and largest radius, whole pixels");
  v.require(r[0] <= r[1] && r[0] == std::floor(r[0]) && r[1] == std::floor(r[1]), "radius_px",
            "[" + text_of(r[0]) + ", " + text_of(r[1]) + "]", "two whole numbers, the smaller one first");
}

}  // namespace saccade
