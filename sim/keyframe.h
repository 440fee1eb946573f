#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <span>
#include <vector>

#include "sim/keyframe_camera.h"
#include "threads/worker_threads.h"

namespace saccade::detail {

/// A layer of the scene as it was drawn once, prepared for reprojection. Values of a sample are means over the area of
/// a pixel around it, so that interpolation between samples gives the mean over a pixel anywhere.
struct Keyframe {
  static constexpr float luminance_step = 1.0F / 257.0F;  ///< grey levels
  static constexpr float cover_step = 1.0F / 65535.0F;

  bool is_drawn = false;
  Eigen::Isometry3d camera_from_layer = Eigen::Isometry3d::Identity();
  Eigen::Matrix3d root_from_layer = Eigen::Matrix3d::Identity();  ///< rotation
  SampleRect rect;  ///< where its samples lie in the KeyframeCamera's image
  SampleRect
      covered;  ///< the part of it that the layer covers, a pixel around included; empty: nothing is there
  bool is_clipped = false;  ///< whether the layer may continue outside the rectangle
  // Inverse depths along the optical axis, 1/m.
  double nearest_1_m = 0.0;
  double farthest_1_m = 0.0;
  double mean_1_m = 0.0;
  double largest_step_1_m = 0.0;  ///< between neighbouring samples
  // Each sample beside the one below it, so that the four samples around a point lie one after the other. Whole numbers of
  // 16 bits keep an image's share of a keyframe in the processor's cache.
  std::vector<std::uint16_t> luminance;  ///< times cover; in units of luminance_step, 0 to 255
  std::vector<std::uint16_t>
      cover;  ///< share of the pixel that the layer covers, in units of cover_step, 0 to 1;
              ///< empty for the room: 1
  // Mean inverse depth of blocks of `block` x `block` samples: of the room as large as a pixel, of a body one sample, and
  // around the body that of its outline.
  int block = 1;
  int block_columns = 0;
  int block_rows = 0;
  std::vector<float> inverse_depth_1_m;
};

/// Makes keyframes of drawn samples.
class KeyframeFilter {
 public:
  /// `camera` outlives it.
  explicit KeyframeFilter(const KeyframeCamera& camera) : camera_(&camera) {}

  /// Sets all of `keyframe` but pose and is_clipped from the samples of keyframe.rect: colours and depths as OpenGL has
  /// them, bottom row first, depth 1 where nothing is drawn. `is_room`: what is not drawn is black and far away. Depths and
  /// colours are prepared beside each other.
  void fill(Keyframe& keyframe, std::span<const std::uint32_t> rgba, std::span<const float> depth,
            double near_m, double far_m, bool is_room, WorkerThreads& threads);

 private:
  void copy_depths(Keyframe& keyframe, std::span<const float> depth, double near_m, double far_m,
                   bool is_room);
  void average_colours(Keyframe& keyframe, std::span<const std::uint32_t> rgba, std::span<const float> depth,
                       bool is_room);
  void take_outline_depths(std::vector<float>& depths, std::size_t columns);
  void mean_over_pixels(const SampleRect& rect, std::vector<std::uint16_t>& pairs, float scale);

  const KeyframeCamera* camera_;
  std::vector<std::uint32_t> samples_;  ///< of one channel, top row first
  std::vector<std::uint32_t> sums_;     ///< along columns
  std::vector<std::uint32_t> row_sums_;
  std::vector<float> depth_row_;
  std::vector<float> depth_row_above_;
  std::vector<float> block_counts_;
  std::vector<float> inside_;
  std::vector<float> outline_;
  std::vector<float> filter_room_;
};

}  // namespace saccade::detail
