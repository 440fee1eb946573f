#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace saccade::detail {

/// Reprojection of a row of an image from a keyframe.
///
/// A pixel with the ray (x, y, 1) and the inverse depth w shows the point that the keyframe has at the sample
///
///     (u, v) = (a0 + t0 w, a1 + t1 w) / (a2 + t2 w)     with a = A (x, y, 1)
///
/// where A and t hold the motion of the layer relative to the camera since the keyframe, and the keyframe's focal length
/// and centre. The keyframe has the inverse depth q = w / (a2 + t2 w) there, which gives w: it is found by fixed-point
/// iteration from the keyframe's mean.
struct WarpRow {
  std::array<float, 9> a;  ///< row by row
  std::array<float, 3> t;
  float start_1_m;  ///< inverse depth in the keyframe at which the iteration begins
  int iterations;   ///< 0 where the motion is a rotation: then all depths give the same sample
  // The keyframe, as in Keyframe. Samples (u, v) count from the first that was drawn.
  const std::uint16_t* samples;
  bool has_cover;
  int left;  ///< the first sample and the first block that are kept
  int top;
  int columns;
  int rows;
  const float* inverse_depth_1_m;  ///< of blocks
  int block_columns;
  int block_rows;
  float blocks_per_sample;
};

/// Rows of results, and room for intermediate ones; each as long as the row.
struct WarpResult {
  float* luminance;
  float* cover;  ///< not written without a cover in the keyframe
  float* inverse_depth_1_m;
  float* u;
  float* v;
  int* at;
};

/// What a body shows of a row.
struct BodyRow {
  const float* luminance;  ///< times cover
  const float* cover;
  const float* inverse_depth_1_m;
};

/// Puts a body into an image of the room, where its cover is above `least` and it is nearer than the room.
void put_over(const BodyRow& body, float least, const float* room_1_m, float* luminance, std::size_t count);

/// `x`, `y`: rays of the `count` pixels, at unit depth.
void warp_row(const WarpRow& warp, const float* x, const float* y, std::size_t count,
              const WarpResult& result);

}  // namespace saccade::detail
