#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <span>
#include <vector>

#include "sim/keyframe_camera.h"
#include "sim/keyframe_rows.h"
#include "threads/large_vector.h"
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
  SampleRect drawn;  ///< the part of the KeyframeCamera's image that was drawn
  SampleRect
      rect;  ///< the samples that are kept: of the room all that were drawn, of a body those that it covers, a
             ///< pixel around included; empty: nothing is there
  bool is_clipped = false;  ///< whether the layer may continue outside of what was drawn
  // Inverse depths along the optical axis, 1/m.
  double nearest_1_m = 0.0;
  double farthest_1_m = 0.0;
  double mean_1_m = 0.0;
  double largest_step_1_m = 0.0;  ///< between neighbouring samples
  // Each sample beside the one below it, so that the four samples around a point lie one after the other. Whole numbers of
  // 16 bits keep an image's share of a keyframe in the processor's cache. These vectors and inverse_depth_1_m may be longer
  // than what is used of them.
  // A sample of a body has four: luminance times cover, in units of luminance_step, 0 to 255, and cover, the share of the pixel
  // that the layer covers, in units of cover_step, 0 to 1. One of the room, whose cover is 1, has the first two.
  LargeVector<std::uint16_t> samples;
  // Mean inverse depth of blocks of `block` x `block` samples: of the room as large as a pixel, of a body one sample, and
  // around the body that of its outline.
  int block = 1;
  int block_columns = 0;
  int block_rows = 0;
  LargeVector<float> inverse_depth_1_m;
};

/// Makes keyframes of drawn samples.
class KeyframeFilter {
 public:
  /// `camera` outlives it.
  explicit KeyframeFilter(const KeyframeCamera& camera) : camera_(&camera) {}

  /// What was drawn: colours and depths of keyframe.rect as OpenGL has them, bottom row first, depth 1 where nothing is.
  struct Drawn {
    std::span<const std::uint32_t> rgba;
    std::span<const float> depth;
    double near_m;
    double far_m;
    bool is_room;  ///< what is not drawn is black and far away
  };
  /// The samples of `drawn` with a depth below 1, and so many around them that fill() gives them the values to the bit that it
  /// gives them in all of `drawn`, where all others are 0; empty where nothing is. `depth`: of `drawn`, and more.
  [[nodiscard]] SampleRect covered_part(const SampleRect& drawn, std::span<const float> depth) const;
  /// Sets the samples of keyframe.rect, which is not empty, and what is known of their depths. Threads share its rows; the result
  /// does not depend on their number.
  void fill(Keyframe& keyframe, const Drawn& drawn, WorkerThreads& threads);

 private:
  /// A share of the rows, with what is computed of it and room for the rows in work.
  struct Band {
    std::vector<std::uint32_t> samples;
    std::vector<std::uint32_t> row_sums;
    std::vector<std::uint32_t> sums;  ///< along columns, of the rows in reach
    std::vector<MeanRun> runs;
    std::vector<MeanRun> column_runs;
    std::vector<std::uint16_t> values;
    std::vector<float> depths;
    std::vector<float> padded;
    std::vector<float> least;
    FloatRange range;
    std::int32_t step = 0;
    std::ptrdiff_t count = 0;  ///< samples that a body covers
  };

  void set_row_runs(const Keyframe& keyframe, int row, Band& band) const;
  void set_column_runs(const Keyframe& keyframe, int row, int ring, float scale, Band& band) const;
  template <class RowOf>
  void mean_over_pixels(const Keyframe& keyframe, int begin, int end, const RowOf& row_of, float scale,
                        std::uint16_t* pairs, std::size_t per_sample, Band& band) const;
  void average_colours(Keyframe& keyframe, const Drawn& drawn, int begin, int end, Band& band) const;
  void copy_depths(Keyframe& keyframe, const Drawn& drawn, int begin, int end, Band& band);
  void sum_up(Keyframe& keyframe, bool is_room);
  void continue_outwards(std::size_t columns);
  void take_outline_depths(Keyframe& keyframe, int begin, int end, Band& band) const;

  const KeyframeCamera* camera_;
  std::vector<Band> bands_;
  // Of a body: inverse depths of the samples, 0 where nothing is drawn; the same continued around the body; the sums of rows.
  LargeVector<float> drawn_1_m_;
  LargeVector<float> continued_1_m_;
  std::vector<double> row_sums_1_m_;
};

}  // namespace saccade::detail
