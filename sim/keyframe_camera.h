#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/camera.h"

namespace saccade::detail {

/// A rectangle of samples of a keyframe: columns [left, right), rows [top, bottom), from the top left.
struct SampleRect {
  int left = 0;
  int top = 0;
  int right = 0;
  int bottom = 0;

  [[nodiscard]] int columns() const { return right - left; }
  [[nodiscard]] int rows() const { return bottom - top; }
  [[nodiscard]] bool is_empty() const { return right <= left || bottom <= top; }
  [[nodiscard]] std::size_t area() const {
    return static_cast<std::size_t>(columns()) * static_cast<std::size_t>(rows());
  }
  [[nodiscard]] SampleRect cut(const SampleRect& by) const;
};

/// The pinhole that keyframes are drawn with: square samples, everything that the camera's lens shows, and a margin
/// around it. Sample i covers [i, i + 1) of a coordinate.
class KeyframeCamera {
 public:
  /// `samples`: per pixel on the optical axis, in each direction. `margin_px`: around the camera's image.
  /// Throws InputError where the keyframe would have more than LensResampler::max_side samples in a row or column.
  KeyframeCamera(const Camera& camera, std::int64_t samples, double margin_px);

  [[nodiscard]] int columns() const { return columns_; }
  [[nodiscard]] int rows() const { return rows_; }
  [[nodiscard]] SampleRect whole() const { return {0, 0, columns_, rows_}; }
  /// Samples per unit of the plane at unit depth, and where the optical axis meets it.
  [[nodiscard]] double focal() const { return focal_; }
  [[nodiscard]] double centre_x() const { return centre_x_; }
  [[nodiscard]] double centre_y() const { return centre_y_; }
  /// Samples per pixel on the optical axis.
  [[nodiscard]] int samples() const { return samples_; }

  /// Sets the frustum of `eye` for drawing `rect` alone; near and far planes are set already.
  void set_frustum(const SampleRect& rect, mjvGLCamera& eye) const;
  /// The samples that a sphere can cover, not cut at the keyframe's border; none if it reaches behind the near plane.
  [[nodiscard]] std::optional<SampleRect> span_of(const Eigen::Vector3d& centre_m, double radius_m,
                                                  double near_m) const;

  /// Width and height of the mean that makes a pixel of the samples around one, in samples: those of the pixel less the
  /// mean that interpolation adds. Outside the camera's image those of its border.
  struct PixelSize {
    float width;
    float height;
  };
  [[nodiscard]] PixelSize pixel_at(int column, int row) const {
    return cells_[static_cast<std::size_t>(row / cell) * cell_columns_ +
                  static_cast<std::size_t>(column / cell)];
  }
  /// A pixel's mean takes no sample more than this many rows or columns away.
  [[nodiscard]] int reach() const { return reach_; }
  static constexpr int cell = 8;  ///< samples that share a PixelSize, in each direction
  /// The first sample of the next ones that share a PixelSize.
  [[nodiscard]] static int next_cell(int sample) { return (sample / cell + 1) * cell; }

 private:
  int samples_;
  int columns_ = 0;
  int rows_ = 0;
  double focal_;
  double centre_x_ = 0.0;
  double centre_y_ = 0.0;
  std::size_t cell_columns_ = 0;
  std::vector<PixelSize> cells_;
  int reach_ = 0;
};

}  // namespace saccade::detail
