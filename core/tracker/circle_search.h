#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/camera.h"
#include "core/event.h"
#include "core/hough/hough_transform.h"
#include "core/reserved_vector.h"

namespace saccade {

/// Finds circles among moving edges: the directed Hough transform (paper, section II-C) over a pyramid of images. Level
/// n has cells of 2^n pixels and radii of 8 to 16 cells, the first level all below 16, so that the work for an edge
/// hardly grows with the largest radius. Does not allocate after construction.
class CircleSearch {
 public:
  /// Radii in pixels, 1 <= r_min <= r_max. At most `max_edges` edges vote on a level. Throws InputError where the image
  /// and the radii need too many cells.
  CircleSearch(ImageSize size, double r_min_px, double r_max_px, double arc_rad, std::size_t max_edges);

  /// Takes back the votes of up to `count` edges of each level. True when none is left: add() may be called again.
  bool clear(std::size_t count);
  /// Adds an edge; `direction` as HoughTransform::direction_of. Ignored outside the image, where another edge of about
  /// this direction is in the same cell, and after `max_edges`.
  void add(const Eigen::Vector2d& at_px, int direction);

  struct Found {
    Circle circle;
    double response = 0.0;  ///< votes per pixel of the circle's ring
  };
  /// The strongest circles, largest response first, each without the edges of those before it; at most `count` of each
  /// level. Valid until the next call.
  [[nodiscard]] std::span<const Found> find(std::size_t count);

  /// Writes the largest response over all radii of all levels at each pixel of the image, row by row. Allocates.
  void largest_response(ImageSize size, std::span<float> response) const;

 private:
  struct Vote {
    std::uint16_t x, y;  // cell
    std::int16_t direction;
    bool explained;  // by a circle that was found, and taken back
  };
  struct Level {
    int cell_px;
    HoughTransform transform;
    std::vector<std::uint8_t> taken;  // per cell, one bit for each quarter of the directions
    ReservedVector<Vote> votes;
  };

  std::size_t max_edges_;
  std::vector<Level> levels_;
  ReservedVector<Found> found_;
};

}  // namespace saccade
