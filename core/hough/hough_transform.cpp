#include "core/hough/hough_transform.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <string>
#include <tuple>
#include <utility>

#include "core/error.h"
#include "core/hough/vote_kernels.h"

namespace saccade {

using namespace vote_kernels;

namespace {

/// Room for rounding where a pixel lies exactly on the edge of an arc: such a pixel is inside.
constexpr double edge_rad = 1e-9;

/// Places whose votes are added plane by plane at a time: less than 2^16.
constexpr std::size_t most_gathered = 8192;
/// Adding plane by plane costs as much as so many patches of single events for each event in a pair of planes, measured.
constexpr std::size_t patches_per_visit = 16;
constexpr std::size_t bound_pixels = 13;        // whose bounds are found in the time of one patch, measured
constexpr std::uint16_t not_gathered = 0xffff;  // no place has this number

/// Largest of the cells that belong to an even plane (0) or to an odd one (1).
int largest(const HalfPatch& cells, std::size_t odd) {
  return std::max({cells[odd], cells[odd + 2], cells[odd + 4], cells[odd + 6]});
}

}  // namespace

struct RingPixel {
  int dx, dy;
  std::size_t plane;
  double angle_rad;  // modulo a half turn, in [0, pi)
};

int HoughTransform::direction_of(double x, double y) {
  // Looked up within an eighth of a turn, where the steps change at tan((k + 1/2) pi / 360). These are further
  // apart than the places of `step_from`: at most one of them lies within a place.
  constexpr int steps = direction_count / 4;
  constexpr int places = 128;
  struct Table {
    std::array<double, steps + 1> end;               // the tangent at which a step ends
    std::array<std::uint8_t, places + 1> step_from;  // the step at the start of a place
  };
  static const Table table = [] {
    Table t{};
    for (int k = 0; k <= steps; ++k)
      t.end[static_cast<std::size_t>(k)] = std::tan((k + 0.5) * std::numbers::pi / direction_count);
    for (std::size_t i = 0; i < t.step_from.size(); ++i) {
      const double tangent = static_cast<double>(i) / places;
      t.step_from[i] =
          static_cast<std::uint8_t>(std::upper_bound(t.end.begin(), t.end.end(), tangent) - t.end.begin());
    }
    return t;
  }();
  const double along = std::abs(x);
  const double across = std::abs(y);
  if (along == 0.0 && across == 0.0) return 0;
  const double tangent = std::min(along, across) / std::max(along, across);
  const int from = table.step_from[static_cast<std::size_t>(tangent * places)];
  const int eighth = from + (tangent >= table.end[static_cast<std::size_t>(from)] ? 1 : 0);
  const int quarter = across > along ? direction_count / 2 - eighth : eighth;
  return quarter > 0 && std::signbit(x) != std::signbit(y) ? direction_count - quarter : quarter;
}

HoughTransform::HoughTransform(ImageSize size, int r_min, int r_max, double arc_rad,
                               Normalisation normalisation)
    : size_(size), r_min_(r_min), avx2_(has_avx2()) {
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
    const int ring_pixels = static_cast<int>(ring.size() - before);
    const int perimeter = static_cast<int>(std::lround(2.0 * std::numbers::pi * r));
    divisor_.push_back(normalisation == Normalisation::ring        ? ring_pixels
                       : normalisation == Normalisation::perimeter ? perimeter
                                                                   : 1);
  }

  // An odd number of cache lines a row, so that rows do not compete for the same places in a cache. What is
  // left of a row's first column goes one row further up than its own: hence the 2.
  const auto blocks_of_rows = [](int rows) { return (rows + block_rows - 1) / block_rows; };
  stride_ = (static_cast<std::size_t>(size.width + r_max + patch_columns + 7) / 8 | 1) * 8;
  block_size_ = stride_ * (block_rows / 2);
  block_reciprocal_ = (std::uint64_t{1} << reciprocal_bits) / block_size_ + 1;
  image_blocks_ = blocks_of_rows(size.height);
  margin_ = static_cast<std::size_t>(blocks_of_rows(r_max + 1 + 2)) * block_size_;
  plane_size_ = margin_ + static_cast<std::size_t>(image_blocks_) * block_size_;
  const std::size_t columns = pairs() * plane_size_ + margin_;
  constexpr auto largest_offset = static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max());
  if (columns >
      std::min<std::uint64_t>({largest_offset, (std::uint64_t{1} << reciprocal_bits) / block_size_ - 1,
                               std::numeric_limits<std::uint64_t>::max() / block_reciprocal_})) {
    throw InputError("radius_px", "[" + std::to_string(r_min) + ", " + std::to_string(r_max) + "]",
                     "fewer radii: for an image of " + std::to_string(size.width) + " x " +
                         std::to_string(size.height) + " pixels the Hough space is too large");
  }
  accumulator_.assign(4 * columns, 0);
  gathered_.reserve(most_gathered);
  gathered_at_.assign(static_cast<std::size_t>(size.pixels()), not_gathered);
  blocks_.resize(columns / block_size_);
  for (Block& block : blocks_) block.limit.fill(0xffff);  // no peak outside the image

  step_begin_.resize((pairs() + 1) * patterns);
  std::vector<RingPixel> arcs;
  for (int direction = 0; direction < direction_count; ++direction) {
    arcs.clear();
    const double centre = direction * std::numbers::pi / direction_count;
    for (const RingPixel& pixel : ring) {
      const double apart = std::abs(pixel.angle_rad - centre);
      if (std::min(apart, std::numbers::pi - apart) <= arc_rad + edge_rad) arcs.push_back(pixel);
    }
    append_patterns(arcs, pattern_of(0, direction));
  }
  append_patterns(ring, pattern_of(0, whole_ring));

  std::vector<int> known(1 << patch_cells, -1);
  for (Step& step : steps_) {
    int& index = known[step.voted];
    if (index < 0) {
      index = static_cast<int>(voted_.size());
      Patch& patch = voted_.emplace_back();
      for (std::size_t i = 0; i < patch_cells; ++i) patch[i] = (step.voted >> i) & 1 ? 0xffff : 0;
    }
    step.voted = static_cast<std::uint32_t>(static_cast<std::size_t>(index) * sizeof(Patch));
  }
}

/// Covers pixels with patches from left to right in each pair of rows of each pair of planes, for events at an
/// even and an odd row. The cells voted for are left as one bit each.
void HoughTransform::append_patterns(std::span<const RingPixel> pixels, std::size_t pattern) {
  for (const int parity : {0, 1}) {
    const auto pair_of = [&](const RingPixel& p) { return std::pair(p.plane / 2, (p.dy + parity) >> 1); };
    std::vector<RingPixel> sorted(pixels.begin(), pixels.end());
    std::sort(sorted.begin(), sorted.end(), [&](const RingPixel& a, const RingPixel& b) {
      return std::tuple(pair_of(a), a.dx) < std::tuple(pair_of(b), b.dx);
    });
    std::size_t begun = 0;  // pairs of planes
    const auto begin_until = [&](std::size_t pairs) {
      for (; begun < pairs; ++begun)
        step_begin_[begun * patterns + pattern] = static_cast<std::uint32_t>(steps_.size());
    };
    const RingPixel* first = nullptr;  // of the patch
    for (const RingPixel& p : sorted) {
      if (first == nullptr || pair_of(p) != pair_of(*first) || p.dx >= first->dx + patch_columns) {
        first = &p;
        const auto [planes, rows] = pair_of(p);
        begin_until(planes + 1);
        steps_.push_back({static_cast<std::int32_t>(static_cast<std::ptrdiff_t>(planes * plane_size_) +
                                                    rows * static_cast<std::ptrdiff_t>(stride_) + p.dx),
                          0});
      }
      const std::size_t cell = 4 * static_cast<std::size_t>(p.dx - first->dx) +
                               2 * static_cast<std::size_t>((p.dy + parity) & 1) + p.plane % 2;
      steps_.back().voted |= 1U << cell;
    }
    begin_until(pairs() + 1);
    ++pattern;
  }
}

struct HoughTransform::Walk {
  std::size_t patches;
  const Step* steps;
  const Votes* voted;
  Votes* accumulator;
  std::size_t last;
  Block* blocks;
  std::uint64_t block_reciprocal;
};

struct HoughTransform::Planes {
  bool from_nothing;
  ImageSize size;
  std::size_t pairs, patterns, stride, block_size, margin, plane_size;
  int image_blocks;
  std::span<const Place> places;
  const std::uint32_t* step_begin;
  const Step* steps;
  const Votes* voted;
  Votes* accumulator;
  Block* blocks;
};

template <int sign>
void HoughTransform::walk(int x, int y, int direction) {
  const std::size_t pattern = pattern_of(y, direction);
  const Walk walk{step_count(pattern), steps_.data() + step_begin_[pattern], voted_[0].data(),
                  accumulator_.data(), column(x, y) + patch_columns - 1,     blocks_.data(),
                  block_reciprocal_};
  above_ |= avx2_ ? add_patches_avx2<sign>(walk) : add_patches<sign, HalfPatch>(walk);
}

template <int sign>
void HoughTransform::vote_ring(int x, int y) {
  walk<sign>(x, y, whole_ring);
}

template <int sign>
void HoughTransform::vote_arcs(int x, int y, int direction) {
  walk<sign>(x, y, direction);
}

template void HoughTransform::vote_ring<1>(int, int);
template void HoughTransform::vote_ring<-1>(int, int);
template void HoughTransform::vote_arcs<1>(int, int, int);
template void HoughTransform::vote_arcs<-1>(int, int, int);

void HoughTransform::vote(const EventWindow::Change& change) {
  std::size_t steps = 0;
  for (const auto events : {change.left, change.entered})
    for (const WindowEvent& e : events) steps += step_count(pattern_of(e.y, e.direction));
  const std::size_t visits = change.left.size() + change.entered.size();
  const auto pixels = static_cast<std::size_t>(size_.pixels());
  if (steps <= pairs() * (patches_per_visit * visits + pixels / bound_pixels)) {
    if (change.all_left) clear();
    for (const WindowEvent& e : change.left) walk<-1>(e.x, e.y, e.direction);
    for (const WindowEvent& e : change.entered) walk<1>(e.x, e.y, e.direction);
    return;
  }
  bool from_nothing = change.all_left;
  const auto gather = [&](std::span<const WindowEvent> events, Votes weight) {
    for (const WindowEvent& e : events) {
      if (gathered_.size() == most_gathered) vote_gathered(std::exchange(from_nothing, false));
      const auto pixel = static_cast<std::uint32_t>(e.y * size_.width + e.x);
      if (e.direction == whole_ring) {
        std::uint16_t& place = gathered_at_[pixel];
        if (place != not_gathered) {
          gathered_[place].weight = static_cast<Votes>(gathered_[place].weight + weight);
          continue;
        }
        place = static_cast<std::uint16_t>(gathered_.size());
      }
      gathered_.push_back({static_cast<std::uint32_t>(column(e.x, e.y)), pixel,
                           static_cast<std::uint16_t>(pattern_of(e.y, e.direction)), weight});
    }
  };
  gather(change.left, static_cast<Votes>(-1));
  gather(change.entered, 1);
  vote_gathered(from_nothing);
}

void HoughTransform::vote_gathered(bool from_nothing) {
  const Planes planes{from_nothing,
                      size_,
                      pairs(),
                      patterns,
                      stride_,
                      block_size_,
                      margin_,
                      plane_size_,
                      image_blocks_,
                      gathered_,
                      step_begin_.data(),
                      steps_.data(),
                      voted_[0].data(),
                      accumulator_.data(),
                      blocks_.data()};
  avx2_ ? add_planes_avx2(planes) : add_planes<HalfPatch>(planes);
  above_ = true;
  for (const Place& place : gathered_) gathered_at_[place.pixel] = not_gathered;
  gathered_.clear();
}

void HoughTransform::clear() {
  std::fill(accumulator_.begin(), accumulator_.end(), Votes{0});
  for (Block& block : blocks_) block.bound = {};
  above_ = true;
}

HoughTransform::Peak HoughTransform::peak() const {
  if (above_ || votes(peak_.x, peak_.y, peak_.r) != peak_.votes) {
    peak_ = search();
    set_limits();
  }
  return peak_;
}

HoughTransform::Peak HoughTransform::search() const {
  std::array<int, 256> most;  // in each plane, at most
  const auto bound_of = [&](std::size_t plane, int begin, int end) {
    HalfPatch bound{}, half;
    for (int block = begin; block < end; ++block) {
      for (std::size_t part = 0; part < patch_cells; part += patch_cells / 2) {
        load(half, blocks_of(plane)[block].bound.data() + part);
        raise(bound, half);
      }
    }
    return bound;
  };
  const auto bound_planes = [&](std::size_t plane) {
    const HalfPatch bound = bound_of(plane, 0, image_blocks_);
    for (std::size_t odd = 0; odd < 2; ++odd) most[plane / 2 * 2 + odd] = largest(bound, odd);
  };
  for (std::size_t plane = 0; plane < divisor_.size(); plane += 2) bound_planes(plane);
  for (;;) {
    // Votes / pixels compared as fractions: exact.
    std::size_t best = 0;
    for (std::size_t plane = 1; plane < divisor_.size(); ++plane) {
      if (most[plane] * static_cast<std::int64_t>(divisor_[best]) >
          most[best] * static_cast<std::int64_t>(divisor_[plane])) {
        best = plane;
      }
    }
    if (most[best] == 0) return {0, 0, r_min_, 0, 0.0};
    int block = 0;
    while (largest(bound_of(best, block, block + 1), best % 2) < most[best]) ++block;
    if (const auto peak = search_block(best, block, most[best])) return *peak;
    bound_planes(best);
  }
}

/// The first cell of a plane in a block that has so many votes. If there is none, the block's bound is exact.
std::optional<HoughTransform::Peak> HoughTransform::search_block(std::size_t plane, int block,
                                                                 int votes) const {
  const int end = std::min(size_.height, (block + 1) * block_rows);
  HalfPatch bound{};
  for (int y = block * block_rows; y < end; y += 2) {
    const Votes* at = votes_at(0, y, plane / 2 * 2);
    HalfPatch most{}, half;
    int x = 0;
    for (; x + 2 <= size_.width; x += 2, at += 8) {
      load(half, at);
      raise(most, half);
    }
    if (x < size_.width) raise(most, HalfPatch{at[0], at[1], at[2], at[3]});
    if (y + 1 == size_.height) most &= HalfPatch{0xffff, 0xffff, 0, 0, 0xffff, 0xffff, 0, 0};
    raise(bound, most);
    if (largest(most, plane % 2) < votes) continue;
    for (const int row : {y, y + 1}) {
      for (x = 0; x < size_.width && row < end; ++x) {
        if (*votes_at(x, row, plane) != votes) continue;
        return Peak{x, row, r_min_ + static_cast<int>(plane), votes,
                    static_cast<double>(votes) / divisor_[plane]};
      }
    }
  }
  Patch& exact = blocks_of(plane)[block].bound;
  exact = {};
  std::memcpy(exact.data(), &bound, sizeof bound);
  return std::nullopt;
}

/// The most votes that cells can have without taking the peak's place.
void HoughTransform::set_limits() const {
  above_ = false;
  const auto own = static_cast<std::size_t>(peak_.r - r_min_);
  const int own_block = peak_.y / block_rows;
  for (std::size_t pair = 0; pair < divisor_.size(); pair += 2) {
    Patch until_own{}, after_own{};
    for (std::size_t i = 0; i < patch_cells; ++i) {
      const std::size_t plane = std::min(pair + i % 2, divisor_.size() - 1);
      const int equal = peak_.votes * divisor_[plane];
      const auto limit = [&](bool equal_wins) {
        return static_cast<Votes>(std::min((equal - (equal_wins ? 1 : 0)) / divisor_[own], 0xffff));
      };
      until_own[i] = limit(plane <= own);
      after_own[i] = limit(plane < own);
    }
    for (int block = 0; block < image_blocks_; ++block) {
      blocks_of(pair)[block].limit = block <= own_block ? until_own : after_own;
    }
  }
}

int HoughTransform::votes(int x, int y, int r) const {
  return *votes_at(x, y, static_cast<std::size_t>(r - r_min_));
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

}  // namespace saccade
