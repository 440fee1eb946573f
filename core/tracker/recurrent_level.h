#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/tracker/recurrent_model.h"

namespace saccade {

/// The recurrent network on one level of the pyramid (docs/training.md): a map of cells in, a map of squares of 4 x 4 cells out,
/// and the memory of each square from step to step. The work is done in rows. Does not allocate after construction.
class RecurrentLevel {
 public:
  static constexpr int square = 4;  ///< cells
  /// Maps between the stages; levels that work one after the other share one.
  struct Maps {
    std::vector<float> first, a, b;  ///< rows x columns x channels
    void reserve(int rows, int columns);
  };
  /// Numbers of an output square, in the order of the model.
  struct Square {
    float log_odds;            ///< that a ball's centre is there
    float x, y;                ///< of the centre from the middle of the square, squares
    float log2_radius;         ///< relative to mean_cells cells
    float vx, vy;              ///< of the centre, squares per 100 ms
    float log_sd_centre;       ///< of x and y, squares
    float log_sd_log2_radius;  ///< of log2_radius
    float inlier_log_odds;     ///< that the circle is within 6 px of the ball's centre and 2 px of its radius
  };
  static constexpr double mean_cells = 5.66;

  /// rows, columns: of cells, multiples of `square`.
  RecurrentLevel(std::shared_ptr<const RecurrentModel> model, int rows, int columns);

  [[nodiscard]] int rows() const { return rows_; }
  [[nodiscard]] int columns() const { return columns_; }

  struct Step {
    float dt_ms;                 ///< since the step before
    int shift_x, shift_y;        ///< squares by which the camera's rotation has moved the image since then
    std::array<float, 2> speed;  ///< of the image by that rotation, squares per 100 ms
    bool rotation_known;         ///< else speed and shift are 0
  };
  /// What a step starts from: rows x columns x RecurrentModel::inputs. Written before the step's first row.
  [[nodiscard]] std::span<float> input() { return input_; }
  /// Moves the memory and starts a step.
  void begin(const Step& step);
  /// One row of the stage under way: the multiplications that it took at most. 0 without a step under way.
  std::int64_t row(Maps& maps);
  [[nodiscard]] bool busy() const { return stage_ < stages; }
  /// Of a step at most.
  [[nodiscard]] std::int64_t multiplications() const;

  /// Of the last complete step, row by row.
  [[nodiscard]] std::span<const Square> output() const { return output_; }
  /// Of the memory of block 2 (0) or 4 (1): squares x channels.
  [[nodiscard]] std::span<const float> memory(std::size_t n) const { return memory_[n]; }

 private:
  using Model = RecurrentModel;
  static constexpr std::size_t stages = 3 + Model::blocks;

  std::shared_ptr<const RecurrentModel> model_;
  int rows_, columns_;
  std::array<std::vector<float>, Model::memories> memory_;
  std::vector<float> input_;
  std::vector<Square> output_;
  std::array<std::array<float, Model::channels>, Model::motion_outputs> bias_;  // of the step
  float dt_ms_ = 0.0F;
  std::size_t stage_ = stages;
  int row_ = 0;
};

}  // namespace saccade
