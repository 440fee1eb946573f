#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/camera.h"
#include "core/time_surface.h"
#include "core/tracker/recurrent_level.h"

namespace saccade {

/// Finds balls in the events of the whole image with a network that has memory (docs/training.md). Input: exp(-age / tau) of the
/// newest ON and OFF event of each pixel (a time surface), tau = 4, 16, 64 and 256 ms, summed over cells of 1, 2, 4 and 8 px, times cell^-1.5;
/// each level of cells finds radii of 3.6 to 9 cells, with the same weights.
///
/// A step's work is done in rows of a bounded number of multiplications. Does not allocate after construction.
class RecurrentNetwork {
 public:
  RecurrentNetwork(std::shared_ptr<const RecurrentModel> model, ImageSize size, double r_min_px,
                   double r_max_px);

  /// Starts a step on the events up to now_us. `image_shift_px`: how far the camera's rotation has moved the middle of the
  /// image since the step before; none where it is not known. The last result stays until the new one is complete.
  void begin(std::int64_t now_us, const std::optional<Eigen::Vector2d>& image_shift_px);
  /// Goes on for about `multiplications`, on a time surface of the image's size. True when the result is complete; without
  /// begin() before: false.
  bool work(const TimeSurface& surface, std::int64_t multiplications);
  [[nodiscard]] bool busy() const { return level_ < levels_.size(); }

  struct Found {
    Circle circle;
    Eigen::Vector2d speed_px_s;  ///< of the centre in the image
    double centre_sd_px, radius_sd_px;
    double centre_log_odds;  ///< that a ball's centre is there
    double inlier_log_odds;  ///< that the circle is an inlier (docs/scoring.md)
  };
  static constexpr std::size_t found_per_level = 4;
  /// The strongest local maxima of each level in the last complete result, by inlier_log_odds, greatest first.
  [[nodiscard]] std::span<const Found> found() const { return {found_.data(), found_count_}; }
  /// When begin() was called for that result.
  [[nodiscard]] std::int64_t found_at_us() const { return found_at_us_; }
  /// Multiplications of a step at most.
  [[nodiscard]] std::int64_t multiplications() const;

 private:
  struct Level {
    int cell_px;
    RecurrentLevel network;
    Eigen::Vector2d shift_rest =
        Eigen::Vector2d::Zero();  // squares, that the memory has not been moved by yet
  };

  void begin_level();
  void input_row(Level& level, const TimeSurface& surface);
  void take_result();

  ImageSize size_;
  std::vector<Level> levels_;
  RecurrentLevel::Maps maps_;
  std::array<Found, 4 * found_per_level> found_;
  std::size_t found_count_ = 0;
  std::optional<Eigen::Vector2d> image_shift_px_;  // of the step
  double dt_ms_ = 0.0;
  std::int64_t now_us_, found_at_us_;
  std::size_t level_;  // under way; past the end: none
  std::size_t
      input_level_;    // whose input is being made, before the first level is under way; past the end: none
  int input_row_ = 0;  // of it
};

}  // namespace saccade
