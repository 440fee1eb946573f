#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "core/camera.h"
#include "core/time_surface.h"
#include "core/tracker/best_model.h"

namespace saccade {

/// A small convolutional network that detects discs in the time surface. It needs no flow, so it detects a ball where flow
/// fails: in motion blur, on texture, in noise.
///
/// Input: a time surface, as exp(-age / tau) of the newest ON and OFF event of each pixel, tau = 4, 16, 64 and 256 ms, averaged over cells of
/// 1, 2, 4 and 8 px: on each level the network finds radii of 4 to 8 cells, with the same weights. Output, for every 4 x 4
/// cells: the log odds that a ball's centre is there, its offset, and its radius.
///
/// The work is done in steps of a bounded number of multiplications. Does not allocate after construction.
class DiscNetwork {
 public:
  DiscNetwork(std::shared_ptr<const BestModel> model, ImageSize size, double r_min_px, double r_max_px);

  /// Starts an inference at now_us. The last result stays until the new one is complete.
  void begin(std::int64_t now_us);
  /// Goes on for about `multiplications` with the surface as it is now, whose size is that of the network. True when the
  /// result is complete; without begin() before: false.
  bool work(const TimeSurface& surface, std::int64_t multiplications);
  [[nodiscard]] bool busy() const { return level_ < levels_.size(); }

  struct Found {
    Circle circle;
    float log_odds = 0.0F;
  };
  /// The strongest local maxima of the last complete result, strongest first; at most 8.
  [[nodiscard]] std::span<const Found> found() const { return {found_.data(), found_count_}; }
  /// When begin() was called for that result.
  [[nodiscard]] std::int64_t found_at_us() const { return found_at_us_; }
  /// The strongest circle of the last complete result that is about `circle`: nearer than 0.4 radii to it in place and
  /// radius. log_odds is `nothing` where there is none.
  [[nodiscard]] Found about(const Circle& circle) const;
  static constexpr float nothing = -12.0F;

 private:
  static constexpr std::size_t channels = DiscNetworkWeights::channels,
                               first_channels = DiscNetworkWeights::first_channels,
                               input_channels = DiscNetworkWeights::inputs,
                               outputs = DiscNetworkWeights::outputs;
  struct Level {
    int cell_px;
    int rows, columns;                                     // cells, whole multiples of 4
    std::vector<std::array<float, outputs>> result, next;  // of each 4 x 4 cells
  };

  [[nodiscard]] std::int64_t row(Level& level, const TimeSurface& surface);
  void input_row(const Level& level, const TimeSurface& surface);
  void first_row(const Level& level);
  void second_row(const Level& level);
  void block_row(const Level& level, std::size_t block);
  void output_row(Level& level);
  void take_result();
  [[nodiscard]] Found circle_of(const Level& level, int x, int y) const;

  std::shared_ptr<const BestModel> model_;
  ImageSize size_;
  std::vector<Level> levels_;
  std::vector<float> input_, first_, a_, b_;  // rows x columns x channels; reused by each level
  std::array<Found, 8> found_;
  std::size_t found_count_ = 0;
  std::int64_t now_us_ = 0, found_at_us_ = std::numeric_limits<std::int64_t>::min();
  std::size_t level_;      // under way; past the end: none
  std::size_t stage_ = 0;  // of the level
  int row_ = 0;            // of the stage
};

}  // namespace saccade
