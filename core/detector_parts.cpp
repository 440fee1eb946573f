#include "core/detector_parts.h"

#include <algorithm>

#include "core/error.h"

#include <cmath>

namespace saccade::inline v0_1 {

void describe_radius_px(FieldVisitor& v, std::array<double, 2>& r) {
  v.reals("radius_px", r, {1, 255}, "smallest and largest radius, whole pixels");
  v.require(r[0] <= r[1] && r[0] == std::floor(r[0]) && r[1] == std::floor(r[1]), "radius_px",
            "[" + text_of(r[0]) + ", " + text_of(r[1]) + "]", "two whole numbers, the smaller one first");
}

void largest_response(const HoughTransform& transform, std::span<float> response) {
  const ImageSize size = transform.size();
  SACCADE_CHECK(std::ssize(response) == size.pixels());
  std::fill(response.begin(), response.end(), 0.0F);
  for (int r = transform.r_min(); r <= transform.r_max(); ++r) {
    const float weight = 1.0F / static_cast<float>(transform.divisor(r));
    for (int y = 0, i = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x, ++i) {
        float& largest = response[static_cast<std::size_t>(i)];
        largest = std::max(largest, weight * static_cast<float>(transform.votes(x, y, r)));
      }
    }
  }
}

}  // namespace saccade::inline v0_1
