#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

/// How HoughTransform adds votes with vectors of 128 bits, or of 256 where the processor has them; hough_transform.cpp alone
/// includes it. `Walk` and `Planes` are its structs.
namespace saccade::vote_kernels {

inline constexpr int patch_columns = 4;         // 4 x 4 cells of 16 bits fill one vector of 256 bits
inline constexpr std::size_t patch_cells = 16;  // of a patch
inline constexpr int block_rows = 8;  // of cells that lie together: a vote's cells are in few cache lines
/// Columns are divided by the columns of a block with a multiplication by 2^48 / block, rounded up: exact below
/// 2^48 / block, and the product fits into 64 bits.
inline constexpr int reciprocal_bits = 48;

using HalfPatch [[gnu::vector_size(16)]] = std::uint16_t;
using WholePatch [[gnu::vector_size(32)]] = std::uint16_t;  // only where AVX2 is, and never by value

template <class Vector>
[[gnu::always_inline]] inline void load(Vector& vector, const std::uint16_t* from) {
  std::memcpy(&vector, from, sizeof vector);
}

template <class Vector>
[[gnu::always_inline]] inline void raise(Vector& most, const Vector& by) {
  most = most > by ? most : by;
}

/// Adds the patches of a walk, or takes them out again. True if a cell now has more votes than its limit.
template <int sign, class Vector, class Walk>
[[gnu::always_inline]] inline bool add_patches(const Walk& walk) {
  const Walk w = walk;  // nothing else points to it
  Vector above{};
  for (std::size_t i = 0; i < w.patches; ++i) {
    // A patch belongs to the block of its last column: its first may lie in the row before.
    const std::size_t last =
        w.last + static_cast<std::size_t>(static_cast<std::ptrdiff_t>(w.steps[i].columns));
    auto& block = w.blocks[(last * w.block_reciprocal) >> reciprocal_bits];
    for (std::size_t part = 0; part < patch_cells; part += sizeof(Vector) / sizeof(std::uint16_t)) {
      std::uint16_t* const at = w.accumulator + 4 * last - 4 * (patch_columns - 1) + part;
      Vector voted, votes, bound, limit;
      load(voted, w.voted + w.steps[i].voted / sizeof(std::uint16_t) + part);
      load(votes, at);
      votes = sign > 0 ? votes - voted : votes + voted;
      std::memcpy(at, &votes, sizeof votes);
      if (sign < 0) continue;
      votes &= voted;
      load(bound, block.bound.data() + part);
      raise(bound, votes);
      std::memcpy(block.bound.data() + part, &bound, sizeof bound);
      load(limit, block.limit.data() + part);
      raise(votes, limit);
      above |= votes ^ limit;
    }
  }
  std::array<std::uint64_t, sizeof above / 8> words;
  std::memcpy(words.data(), &above, sizeof above);
  return std::any_of(words.begin(), words.end(), [](std::uint64_t word) { return word != 0; });
}

/// The most votes of a pair of planes in the rows of a block, for each place in a patch.
template <class Vector, class Planes>
[[gnu::always_inline]] inline void find_bound(const Planes& p, const std::uint16_t* plane, int block,
                                              std::uint16_t* bound) {
  constexpr int columns = static_cast<int>(sizeof(Vector) / sizeof(std::uint64_t));
  Vector most{}, upper_row{};
  for (std::size_t i = 0; i < sizeof(Vector) / sizeof(std::uint16_t); ++i) upper_row[i] = i & 2 ? 0 : 0xffff;
  for (int y = block * block_rows; y < std::min(p.size.height, (block + 1) * block_rows); y += 2) {
    const std::uint16_t* at = plane + 4 * static_cast<std::size_t>(y / 2) * p.stride;
    Vector row{}, votes;
    int x = 0;
    for (; x + columns <= p.size.width; x += columns, at += 4 * columns) {
      load(votes, at);
      raise(row, votes);
    }
    Vector rest{};
    std::memcpy(&rest, at, static_cast<std::size_t>(p.size.width - x) * sizeof(std::uint64_t));
    raise(row, rest);
    if (y + 1 == p.size.height) row &= upper_row;
    raise(most, row);
  }
  std::memcpy(bound, &most, sizeof most);
}

/// Adds the votes of places, radius by radius, and finds the bounds.
template <class Vector, class Planes>
[[gnu::always_inline]] inline void add_planes(const Planes& planes) {
  const Planes p = planes;  // nothing else points to it
  for (std::size_t pair = 0; pair < p.pairs; ++pair) {
    if (p.from_nothing) {
      // What is below a plane is the margin above the next one.
      std::fill(p.accumulator + 4 * (pair * p.plane_size + (pair > 0 ? p.margin : 0)),
                p.accumulator + 4 * ((pair + 1) * p.plane_size + p.margin), std::uint16_t{0});
    }
    const std::uint32_t* const begin = p.step_begin + pair * p.patterns;
    const std::uint32_t* const end = begin + p.patterns;
    for (const auto& place : p.places) {
      if (place.weight == 0) continue;
      const Vector weight = Vector{} + place.weight;
      std::uint16_t* const event = p.accumulator + 4 * std::size_t{place.column};
      const auto* const last_step = p.steps + end[place.pattern];
      for (const auto* step = p.steps + begin[place.pattern]; step < last_step; ++step) {
        std::uint16_t* const at = event + 4 * static_cast<std::ptrdiff_t>(step->columns);
        const std::uint16_t* const patch = p.voted + step->voted / sizeof(std::uint16_t);
        for (std::size_t part = 0; part < patch_cells; part += sizeof(Vector) / sizeof(std::uint16_t)) {
          Vector voted, votes;
          load(voted, patch + part);
          load(votes, at + part);
          votes += voted & weight;
          std::memcpy(at + part, &votes, sizeof votes);
        }
      }
    }
    auto* const blocks = p.blocks + (pair * p.plane_size + p.margin) / p.block_size;
    for (int block = 0; block < p.image_blocks; ++block) {
      blocks[block].bound = {};
      find_bound<Vector>(p, p.accumulator + 4 * (pair * p.plane_size + p.margin), block,
                         blocks[block].bound.data());
    }
  }
}

#ifdef __x86_64__
inline bool has_avx2() { return __builtin_cpu_supports("avx2"); }
template <int sign, class Walk>
[[gnu::target("avx2")]] bool add_patches_avx2(const Walk& walk) {
  return add_patches<sign, WholePatch>(walk);
}
template <class Planes>
[[gnu::target("avx2")]] void add_planes_avx2(const Planes& planes) {
  add_planes<WholePatch>(planes);
}
#else
inline bool has_avx2() { return false; }
template <int sign, class Walk>
bool add_patches_avx2(const Walk& walk) {
  return add_patches<sign, HalfPatch>(walk);
}
template <class Planes>
void add_planes_avx2(const Planes& planes) {
  add_planes<HalfPatch>(planes);
}
#endif

}  // namespace saccade::vote_kernels
