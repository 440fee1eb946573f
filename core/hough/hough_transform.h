#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/config.h"
#include "core/event.h"
#include "core/hough/event_window.h"
#include "core/reserved_vector.h"

namespace saccade {

/// The multi-radius circular Hough transform of the paper (section II-B and II-C), one accumulator plane per
/// radius, bins of one pixel, centres inside the image.
///
/// An event votes for the centres of all circles that it can lie on: the pixels (dx, dy) from it with
/// |sqrt(dx^2 + dy^2) - r| <= 1/2 (half-pixel ring). A directed vote is restricted to the two arcs of that ring within
/// +-`arc_rad` of the flow direction and of its opposite (Eq. 2). The response at a centre is votes / (number of pixels
/// of the ring), so that it does not grow with the radius.
///
/// A vote adds precomputed patches of 4 x 2 cells of two neighbouring radii: no trigonometry, no bounds check, no
/// allocation. The votes of single events also update the bounds by which peak() avoids a search. Those of many events are
/// added for one pair of radii after the other, so that the cells stay in the cache, events of the same pixel together, and
/// then the bounds are found anew. A patch takes one instruction with AVX2 and two without, with the same result.
class HoughTransform {
 public:
  /// Directions are counted in steps of half a degree, modulo a half turn: an arc and its opposite are one.
  static constexpr int direction_count = 360;
  /// In place of the direction of an event that votes for the whole ring.
  static constexpr std::int16_t whole_ring = -1;
  /// The direction step nearest to the direction of the vector (x, y); 0 for the zero vector.
  [[nodiscard]] static int direction_of(double x, double y);

  /// The divisor of the votes for a circle: the pixels of its half-pixel ring (as in the paper), its perimeter
  /// (rounded; inaccurate for small circles according to the paper), or 1.
  enum class Normalisation { ring, perimeter, none };
  friend constexpr auto words_of(Normalisation) {
    return std::to_array<Word<Normalisation>>({{Normalisation::ring, "ring"},
                                               {Normalisation::perimeter, "perimeter"},
                                               {Normalisation::none, "none"}});
  }

  /// Radii r_min..r_max in steps of 1 px, 1 <= r_min <= r_max <= 255; arc_rad in (0, pi/2]. Throws InputError where
  /// image and radii need more than about 2^33 cells.
  HoughTransform(ImageSize size, int r_min, int r_max, double arc_rad,
                 Normalisation normalisation = Normalisation::ring);

  /// Adds (`sign` +1) or removes (-1) the votes of an event, one per centre. A cell holds at most 65535 votes. (x, y) is
  /// inside the image; direction in [0, direction_count).
  template <int sign>
  void vote_ring(int x, int y);
  template <int sign>
  void vote_arcs(int x, int y, int direction);
  void clear();
  /// Removes the votes of the events that have left a window and adds those of the ones that have entered it.
  void vote(const EventWindow::Change& change);

  struct Peak {
    int x = 0, y = 0, r = 0;
    int votes = 0;
    double response = 0.0;  ///< votes / divisor(r)
  };
  /// The cell with the largest response, exactly; ties go to the smaller r, then y, then x. Empty: r_min, (0, 0) and 0
  /// votes. Without a search if the last peak has kept its votes and no other cell has reached its response; otherwise
  /// blocks of rows are searched by falling upper bound until a cell reaches the bound of its block.
  [[nodiscard]] Peak peak() const;

  [[nodiscard]] int votes(int x, int y, int r) const;
  /// The divisor of the votes for radius r.
  [[nodiscard]] int divisor(int r) const { return divisor_[static_cast<std::size_t>(r - r_min_)]; }
  [[nodiscard]] int r_min() const { return r_min_; }
  [[nodiscard]] int r_max() const { return r_min_ + static_cast<int>(divisor_.size()) - 1; }
  [[nodiscard]] ImageSize size() const { return size_; }

 private:
  using Votes = std::uint16_t;
  /// 4 columns of 2 rows of 2 radii, the radii side by side.
  using Patch = std::array<Votes, 16>;
  /// Of the votes in some rows of a pair of planes, for each place in a patch.
  struct alignas(64) Block {
    Patch bound{};  ///< no cell has more
    Patch limit{};  ///< a cell with more may be the next peak
  };

  /// Counted in columns, which hold the 2 x 2 cells of two rows and two radii.
  [[nodiscard]] std::size_t column(int x, int y) const {
    return margin_ + static_cast<std::size_t>(y / 2) * stride_ + static_cast<std::size_t>(x);
  }
  [[nodiscard]] const Votes* votes_at(int x, int y, std::size_t plane) const {
    return accumulator_.data() + 4 * (plane / 2 * plane_size_ + column(x, y)) + 2 * (y % 2) + plane % 2;
  }
  [[nodiscard]] Block* blocks_of(std::size_t plane) const {
    return blocks_.data() + plane / 2 * (plane_size_ / block_size_) + margin_ / block_size_;
  }
  /// A patch of an event's votes.
  struct Step {
    std::int32_t columns;  ///< from the even row of the event's pair, in the planes of the first radii
    std::uint32_t voted;   ///< bytes from the first of voted_
  };
  /// The votes of all events of a pixel, or of one event for arcs.
  struct Place {
    std::uint32_t column;
    std::uint32_t pixel;
    std::uint16_t pattern;  ///< see pattern_of()
    Votes weight;           ///< modulo 2^16
  };

  /// Of an even and an odd row.
  void append_patterns(std::span<const struct RingPixel> pixels, std::size_t pattern);
  [[nodiscard]] static std::size_t pattern_of(int y, int direction) {
    return 2 * static_cast<std::size_t>(direction == whole_ring ? direction_count : direction) +
           static_cast<std::size_t>(y % 2);
  }
  [[nodiscard]] std::size_t pairs() const { return (divisor_.size() + 1) / 2; }
  [[nodiscard]] std::size_t step_count(std::size_t pattern) const {
    return step_begin_[pairs() * patterns + pattern] - step_begin_[pattern];
  }
  struct Walk;
  template <int sign>
  void walk(int x, int y, int direction);
  struct Planes;
  void vote_gathered(bool from_nothing);
  [[nodiscard]] Peak search() const;
  [[nodiscard]] std::optional<Peak> search_block(std::size_t plane, int block, int votes) const;
  void set_limits() const;

  ImageSize size_;
  int r_min_;
  // Planes of rows, outside the image too where votes of its events can fall: what is left of a row is the end
  // of the one before it, and what is below a plane is the margin above the next.
  std::size_t stride_, block_size_, margin_, plane_size_;  // columns; the last two are whole blocks
  std::uint64_t block_reciprocal_;
  int image_blocks_;  // blocks of a plane that have rows of the image
  bool avx2_;
  std::vector<int> divisor_;  // per radius
  // What an event adds: for each direction and then for the whole ring, at an even and at an odd row.
  static constexpr std::size_t patterns = 2 * (direction_count + 1);
  std::vector<std::uint32_t> step_begin_;  // [pair of planes][pattern], and where they end
  std::vector<Step> steps_;                // of a pattern together, one pair of planes after the other
  std::vector<Patch> voted_;               // all bits of a cell that gets a vote
  std::vector<Votes> accumulator_;
  ReservedVector<Place> gathered_;          // in a call of vote()
  std::vector<std::uint16_t> gathered_at_;  // by pixel: which of gathered_ has the rings of its events
  mutable std::vector<Block> blocks_;
  mutable Peak peak_;          // at the last peak()
  mutable bool above_ = true;  // a cell has had more votes than its limit since
};

/// Writes the largest response over all radii at each pixel, row by row. `response` has one element for each pixel.
void largest_response(const HoughTransform& transform, std::span<float> response);

}  // namespace saccade
