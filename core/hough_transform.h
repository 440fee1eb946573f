#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/event.h"

namespace saccade {

/// The multi-radius circular Hough transform of the paper (section II-B and II-C), one accumulator plane per
/// radius, bins of one pixel, centres inside the image.
///
/// An event votes for every centre it could lie on the circle of: the pixels (dx, dy) from it with
/// |sqrt(dx^2 + dy^2) - r| <= 1/2 (half-pixel ring). A directed vote takes of that ring only the two arcs
/// within +-`arc_rad` of the direction of the flow and of its opposite (Eq. 2). The response at a centre is
/// votes / (number of pixels of the ring), so that large circles have no advantage.
///
/// Voting is a walk through a table of patches of 4 x 2 cells that are added as one: no trigonometry, no
/// bounds check, no allocation. An upper bound of every block of rows makes the maximum cheap to find (see
/// peak()).
class HoughTransform {
 public:
  /// Directions are counted in steps of half a degree, modulo a half turn: an arc and its opposite are one.
  static constexpr int direction_count = 360;
  /// The direction step nearest to that of the vector (x, y), which is not zero.
  [[nodiscard]] static int direction_of(double x, double y);

  /// Radii r_min..r_max in steps of 1 px, 1 <= r_min <= r_max <= 255; arc_rad in (0, pi/2].
  HoughTransform(ImageSize size, int r_min, int r_max, double arc_rad);

  /// One vote per centre, `sign` +1 to add an event and -1 to take the same event out again. An event stands
  /// at most 65535 times in a plane. (x, y) inside the image; direction in [0, direction_count).
  template <int sign>
  void vote_ring(int x, int y);
  template <int sign>
  void vote_arcs(int x, int y, int direction);
  void clear();

  struct Peak {
    int x = 0, y = 0, r = 0;
    int votes = 0;
    double response = 0.0;  ///< votes / ring pixels
  };
  /// The largest response; ties go to the smaller r, then y, then x. r_min, (0, 0), 0 votes when empty.
  /// Exact: blocks are looked at in the order of their upper bounds, which become exact by that, until one
  /// holds what its bound says.
  [[nodiscard]] Peak peak() const;

  [[nodiscard]] int votes(int x, int y, int r) const;
  [[nodiscard]] int ring_pixels(int r) const { return ring_pixels_[static_cast<std::size_t>(r - r_min_)]; }
  [[nodiscard]] int r_min() const { return r_min_; }
  [[nodiscard]] int r_max() const { return r_min_ + static_cast<int>(ring_pixels_.size()) - 1; }
  [[nodiscard]] ImageSize size() const { return size_; }

 private:
  using Votes = std::uint16_t;
  /// The votes of a patch: 4 columns x 2 rows, both rows of a column side by side.
  using Patch [[gnu::vector_size(16)]] = Votes;

  [[nodiscard]] std::size_t cell(int x, int y) const {
    return margin_ + static_cast<std::size_t>(y / 2) * row_pair_ + static_cast<std::size_t>(2 * x + y % 2);
  }
  void append_patterns(std::span<const struct RingPixel> pixels);
  template <int sign>
  void walk(int x, int y, std::size_t pattern);
  [[nodiscard]] Patch row_pair_maximum(const Votes* at, int y) const;

  ImageSize size_;
  int r_min_;
  // Planes of row pairs, outside the image too where votes of its events can fall: what is left of a row is
  // the end of the one before it, and what is below a plane is the margin above the next.
  std::size_t row_pair_, margin_, plane_size_;  // cells; row_pair_ is a power of two
  int block_shift_;                             // log2 of the cells of block_rows rows
  std::vector<int> ring_pixels_;                // per radius
  // What an event adds: for each direction and then for the whole ring, at an even and at an odd row.
  std::vector<std::size_t> pattern_begin_;
  std::vector<std::int32_t> patch_offset_;  // from the cell of the event
  std::vector<std::uint8_t> patch_cells_;   // one bit for each cell that gets a vote
  std::vector<Votes> accumulator_;
  mutable std::vector<Patch> bound_;  // of each block: not below any patch of it
};

}  // namespace saccade
