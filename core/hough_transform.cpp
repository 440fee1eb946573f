#include "core/hough_transform.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.h"

namespace saccade {
namespace {

/// Room for rounding where a pixel lies exactly on the edge of an arc: such a pixel is inside.
constexpr double edge_rad = 1e-9;

}  // namespace

int HoughTransform::direction_of(double x, double y) {
  const double half_turns = std::atan2(y, x) / std::numbers::pi;
  const int step = static_cast<int>(std::lround(half_turns * direction_count));
  return (step + 2 * direction_count) % direction_count;
}

HoughTransform::HoughTransform(ImageSize size, int r_min, int r_max, double arc_rad)
    : size_(size),
      r_min_(r_min),
      border_(r_max + 1),
      stride_(size.width + 2 * border_),
      plane_size_(stride_ * (size.height + 2 * border_)) {
  SACCADE_CHECK(r_min >= 1 && r_min <= r_max && r_max <= 255 && size.width > 0 && size.height > 0);
  SACCADE_CHECK(arc_rad > 0.0 && arc_rad <= std::numbers::pi / 2 + edge_rad);
  struct RingPixel {
    std::int32_t offset;
    double angle_rad;  // modulo a half turn, in [0, pi)
  };
  std::vector<RingPixel> ring;
  for (int r = r_min; r <= r_max; ++r) {
    const std::size_t before = ring.size();
    for (int dy = -r - 1; dy <= r + 1; ++dy) {
      for (int dx = -r - 1; dx <= r + 1; ++dx) {
        if (std::abs(std::hypot(dx, dy) - r) > 0.5) continue;
        double angle = std::atan2(dy, dx);
        if (angle < 0.0) angle += std::numbers::pi;
        if (angle >= std::numbers::pi) angle -= std::numbers::pi;
        ring.push_back({static_cast<std::int32_t>((r - r_min) * plane_size_ + dy * stride_ + dx), angle});
      }
    }
    ring_pixels_.push_back(static_cast<int>(ring.size() - before));
  }
  for (const RingPixel& pixel : ring) ring_offsets_.push_back(pixel.offset);
  for (int direction = 0; direction < direction_count; ++direction) {
    arc_begin_.push_back(arc_offsets_.size());
    const double centre = direction * std::numbers::pi / direction_count;
    for (const RingPixel& pixel : ring) {
      const double apart = std::abs(pixel.angle_rad - centre);
      if (std::min(apart, std::numbers::pi - apart) <= arc_rad + edge_rad) arc_offsets_.push_back(pixel.offset);
    }
  }
  arc_begin_.push_back(arc_offsets_.size());
  accumulator_.assign(ring_pixels_.size() * static_cast<std::size_t>(plane_size_), 0);
}

template <int sign>
void HoughTransform::walk(std::ptrdiff_t at, std::span<const std::int32_t> offsets) {
  Votes* const cells = accumulator_.data() + at;
  for (const std::int32_t offset : offsets) cells[offset] = static_cast<Votes>(cells[offset] + sign);
}

template <int sign>
void HoughTransform::vote_ring(int x, int y) {
  walk<sign>(cell(x, y), ring_offsets_);
}

template <int sign>
void HoughTransform::vote_arcs(int x, int y, int direction) {
  const auto d = static_cast<std::size_t>(direction);
  walk<sign>(cell(x, y), std::span(arc_offsets_).subspan(arc_begin_[d], arc_begin_[d + 1] - arc_begin_[d]));
}

template void HoughTransform::vote_ring<1>(int, int);
template void HoughTransform::vote_ring<-1>(int, int);
template void HoughTransform::vote_arcs<1>(int, int, int);
template void HoughTransform::vote_arcs<-1>(int, int, int);

void HoughTransform::clear() { std::fill(accumulator_.begin(), accumulator_.end(), Votes{0}); }

HoughTransform::Peak HoughTransform::peak() const {
  // First the largest count of every plane, a scan that vectorises; then the first cell that has it.
  int best_votes = 0;
  std::size_t best_plane = 0;
  for (std::size_t plane = 0; plane < ring_pixels_.size(); ++plane) {
    const Votes* row = accumulator_.data() + static_cast<std::ptrdiff_t>(plane) * plane_size_ + cell(0, 0);
    Votes most = 0;
    for (int y = 0; y < size_.height; ++y, row += stride_) {
      for (int x = 0; x < size_.width; ++x) most = std::max(most, row[x]);
    }
    // votes / pixels compared as fractions: exact.
    if (most * static_cast<std::int64_t>(ring_pixels_[best_plane]) >
        best_votes * static_cast<std::int64_t>(ring_pixels_[plane])) {
      best_votes = most;
      best_plane = plane;
    }
  }
  Peak peak{0, 0, r_min_ + static_cast<int>(best_plane), best_votes,
            static_cast<double>(best_votes) / ring_pixels_[best_plane]};
  const Votes* row = accumulator_.data() + static_cast<std::ptrdiff_t>(best_plane) * plane_size_ + cell(0, 0);
  for (int y = 0; y < size_.height; ++y, row += stride_) {
    const Votes* found = std::find(row, row + size_.width, static_cast<Votes>(best_votes));
    if (found == row + size_.width) continue;
    peak.x = static_cast<int>(found - row);
    peak.y = y;
    break;
  }
  return peak;
}

int HoughTransform::votes(int x, int y, int r) const {
  return accumulator_[static_cast<std::size_t>((r - r_min_) * plane_size_ + cell(x, y))];
}

}  // namespace saccade
