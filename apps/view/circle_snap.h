#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "core/camera.h"

namespace saccade {

/// The circle of the moving edges near a circle that a person placed. Edges are the events at most `reach_us` from `at_us`
/// that have a normal flow (PlaneFitFlow); with the motion that their flows give, each is carried to `at_us`, and the
/// circle is fitted to them by weighted least squares (CircleFit). Three such fits, each from the last one's circle: the
/// centre moves by at most about 13 px in each direction.
/// `events`: sorted by time; those of the 100 ms before are of use for the flow. None where fewer than five edges lie
/// within a quarter of the radius from the outline (2.5 to 4 px).
[[nodiscard]] std::optional<Circle> snapped_circle(std::span<const Event> events, ImageSize image,
                                                   const Circle& placed, std::int64_t at_us,
                                                   std::int64_t reach_us);

}  // namespace saccade
