#include "core/hough_transform.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <numbers>
#include <tuple>
#include <utility>

#include "core/error.h"

namespace saccade {
namespace {

/// Room for rounding where a pixel lies exactly on the edge of an arc: such a pixel is inside.
constexpr double edge_rad = 1e-9;

constexpr int patch_columns = 4;
constexpr int block_rows = 16;

/// For each set of cells of a patch, one vote in each of them.
constexpr auto votes_of_cells = [] {
  std::array<std::array<std::uint16_t, 8>, 256> votes{};
  for (std::size_t cells = 0; cells < 256; ++cells) {
    for (std::size_t i = 0; i < 8; ++i) votes[cells][i] = (cells >> i) & 1;
  }
  return votes;
}();

template <class Patch>
Patch load(const std::uint16_t* from) {
  Patch patch;
  std::memcpy(&patch, from, sizeof patch);
  return patch;
}

template <class Patch>
Patch larger(Patch a, Patch b) {
  return a > b ? a : b;
}

/// Largest of the even row's votes, and of the odd row's.
template <class Patch>
std::pair<int, int> largest_of_rows(Patch p) {
  p = larger(p, __builtin_shufflevector(p, p, 4, 5, 6, 7, 0, 1, 2, 3));
  p = larger(p, __builtin_shufflevector(p, p, 2, 3, 0, 1, 6, 7, 4, 5));
  return {p[0], p[1]};
}

template <class Patch>
int largest(Patch p) {
  const auto [even, odd] = largest_of_rows(p);
  return std::max(even, odd);
}

}  // namespace

struct RingPixel {
  int dx, dy;
  std::size_t plane;
  double angle_rad;  // modulo a half turn, in [0, pi)
};

int HoughTransform::direction_of(double x, double y) {
  const double half_turns = std::atan2(y, x) / std::numbers::pi;
  const int step = static_cast<int>(std::lround(half_turns * direction_count));
  return (step + 2 * direction_count) % direction_count;
}

HoughTransform::HoughTransform(ImageSize size, int r_min, int r_max, double arc_rad)
    : size_(size), r_min_(r_min) {
  SACCADE_CHECK(r_min >= 1 && r_min <= r_max && r_max <= 255 && size.width > 0 && size.height > 0);
  SACCADE_CHECK(arc_rad > 0.0 && arc_rad <= std::numbers::pi / 2 + edge_rad);
  std::vector<RingPixel> ring;
  for (int r = r_min; r <= r_max; ++r) {
    const std::size_t before = ring.size();
    for (int dy = -r - 1; dy <= r + 1; ++dy) {
      for (int dx = -r - 1; dx <= r + 1; ++dx) {
        if (std::abs(std::hypot(dx, dy) - r) > 0.5) continue;
        double angle = std::atan2(dy, dx);
        if (angle < 0.0) angle += std::numbers::pi;
        if (angle >= std::numbers::pi) angle -= std::numbers::pi;
        ring.push_back({dx, dy, static_cast<std::size_t>(r - r_min), angle});
      }
    }
    ring_pixels_.push_back(static_cast<int>(ring.size() - before));
  }

  const auto whole_blocks = [](int rows) { return (rows + block_rows - 1) / block_rows * block_rows; };
  row_pair_ = 2 * std::bit_ceil(static_cast<std::size_t>(size.width + r_max));
  block_shift_ = std::countr_zero(row_pair_ * (block_rows / 2));
  margin_ = static_cast<std::size_t>(whole_blocks(r_max + 1) / 2) * row_pair_;
  plane_size_ = margin_ + static_cast<std::size_t>(whole_blocks(size.height) / 2) * row_pair_;
  accumulator_.assign(ring_pixels_.size() * plane_size_ + margin_ + row_pair_, 0);
  bound_.assign((accumulator_.size() >> block_shift_) + 1, Patch{});

  std::vector<RingPixel> arcs;
  for (int direction = 0; direction < direction_count; ++direction) {
    arcs.clear();
    const double centre = direction * std::numbers::pi / direction_count;
    for (const RingPixel& pixel : ring) {
      const double apart = std::abs(pixel.angle_rad - centre);
      if (std::min(apart, std::numbers::pi - apart) <= arc_rad + edge_rad) arcs.push_back(pixel);
    }
    append_patterns(arcs);
  }
  append_patterns(ring);
  pattern_begin_.push_back(patch_offset_.size());
}

/// Covers pixels with patches from left to right in each pair of rows, for events at an even and an odd row.
void HoughTransform::append_patterns(std::span<const RingPixel> pixels) {
  for (const int parity : {0, 1}) {
    pattern_begin_.push_back(patch_offset_.size());
    const auto pair_of = [&](const RingPixel& p) { return (p.dy + parity) >> 1; };
    std::vector<RingPixel> sorted(pixels.begin(), pixels.end());
    std::sort(sorted.begin(), sorted.end(), [&](const RingPixel& a, const RingPixel& b) {
      return std::tuple(a.plane, pair_of(a), a.dx) < std::tuple(b.plane, pair_of(b), b.dx);
    });
    const RingPixel* first = nullptr;  // of the patch
    for (const RingPixel& p : sorted) {
      if (first == nullptr || p.plane != first->plane || pair_of(p) != pair_of(*first) ||
          p.dx >= first->dx + patch_columns) {
        first = &p;
        // From the even row of the event's pair.
        patch_offset_.push_back(
            static_cast<std::int32_t>(static_cast<std::ptrdiff_t>(p.plane * plane_size_) +
                                      pair_of(p) * static_cast<std::ptrdiff_t>(row_pair_) + 2 * p.dx));
        patch_cells_.push_back(0);
      }
      patch_cells_.back() |= static_cast<std::uint8_t>(1 << (2 * (p.dx - first->dx) + ((p.dy + parity) & 1)));
    }
  }
}

template <int sign>
void HoughTransform::walk(int x, int y, std::size_t pattern) {
  const std::size_t at = cell(x, y - y % 2);
  const std::size_t begin = pattern_begin_[pattern + static_cast<std::size_t>(y % 2)];
  const std::size_t end = pattern_begin_[pattern + static_cast<std::size_t>(y % 2) + 1];
  const std::int32_t* const offset = patch_offset_.data();
  const std::uint8_t* const cells = patch_cells_.data();
  Votes* const votes = accumulator_.data();
  Patch* const bound = bound_.data();
  const int shift = block_shift_;
  for (std::size_t i = begin; i < end; ++i) {
    const std::size_t k = at + static_cast<std::size_t>(static_cast<std::ptrdiff_t>(offset[i]));
    const Patch one = load<Patch>(votes_of_cells[cells[i]].data());
    const Patch sum = sign > 0 ? load<Patch>(votes + k) + one : load<Patch>(votes + k) - one;
    std::memcpy(votes + k, &sum, sizeof sum);
    if (sign > 0) bound[k >> shift] = larger(bound[k >> shift], sum);
  }
}

template <int sign>
void HoughTransform::vote_ring(int x, int y) {
  walk<sign>(x, y, 2 * direction_count);
}

template <int sign>
void HoughTransform::vote_arcs(int x, int y, int direction) {
  walk<sign>(x, y, 2 * static_cast<std::size_t>(direction));
}

template void HoughTransform::vote_ring<1>(int, int);
template void HoughTransform::vote_ring<-1>(int, int);
template void HoughTransform::vote_arcs<1>(int, int, int);
template void HoughTransform::vote_arcs<-1>(int, int, int);

void HoughTransform::clear() {
  std::fill(accumulator_.begin(), accumulator_.end(), Votes{0});
  std::fill(bound_.begin(), bound_.end(), Patch{});
}

HoughTransform::Patch HoughTransform::row_pair_maximum(const Votes* at, int y) const {
  Patch most{};
  int x = 0;
  for (; x + patch_columns <= size_.width; x += patch_columns, at += 8) most = larger(most, load<Patch>(at));
  for (; x < size_.width; ++x, at += 2) most = larger(most, Patch{at[0], at[1]});
  if (y + 1 == size_.height) most &= Patch{0xffff, 0, 0xffff, 0, 0xffff, 0, 0xffff, 0};
  return most;
}

HoughTransform::Peak HoughTransform::peak() const {
  const int blocks = (size_.height + block_rows - 1) / block_rows;
  const auto bounds_of = [&](std::size_t plane) {
    return bound_.data() + ((plane * plane_size_ + margin_) >> block_shift_);
  };
  std::array<int, 255> plane_bound;
  const auto bound_plane = [&](std::size_t plane) {
    Patch most{};
    for (int block = 0; block < blocks; ++block) most = larger(most, bounds_of(plane)[block]);
    plane_bound[plane] = largest(most);
  };
  for (std::size_t plane = 0; plane < ring_pixels_.size(); ++plane) bound_plane(plane);
  for (;;) {
    // Votes / pixels compared as fractions: exact.
    std::size_t best = 0;
    for (std::size_t plane = 1; plane < ring_pixels_.size(); ++plane) {
      if (plane_bound[plane] * static_cast<std::int64_t>(ring_pixels_[best]) >
          plane_bound[best] * static_cast<std::int64_t>(ring_pixels_[plane])) {
        best = plane;
      }
    }
    const int votes = plane_bound[best];
    if (votes == 0) return {0, 0, r_min_, 0, 0.0};
    int block = 0;
    while (largest(bounds_of(best)[block]) < votes) ++block;
    const Votes* const plane = accumulator_.data() + best * plane_size_;
    const int end = std::min(size_.height, (block + 1) * block_rows);
    Patch most{};
    for (int y = block * block_rows; y < end; y += 2) {
      const Patch row_pair = row_pair_maximum(plane + cell(0, y), y);
      const auto [even, odd] = largest_of_rows(row_pair);
      most = larger(most, row_pair);
      if (std::max(even, odd) < votes) continue;
      // The bound is met: this is its first row.
      int x = 0;
      const int row = even == votes ? y : y + 1;
      while (plane[cell(x, row)] != votes) ++x;
      return {x, row, r_min_ + static_cast<int>(best), votes,
              static_cast<double>(votes) / ring_pixels_[best]};
    }
    bounds_of(best)[block] = most;
    bound_plane(best);
  }
}

int HoughTransform::votes(int x, int y, int r) const {
  return accumulator_[static_cast<std::size_t>(r - r_min_) * plane_size_ + cell(x, y)];
}

}  // namespace saccade
