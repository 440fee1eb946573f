#pragma once

#include <array>

#include "core/model_arrays.h"

namespace saccade {

/// The fitted numbers of RecurrentNetwork (core/tracker/recurrent_network.h): 3 x 3 taps row by row, then channels in, then
/// channels out.
struct RecurrentModel {
  static constexpr std::size_t inputs = 8, first_channels = 16, channels = 48, outputs = 9, blocks = 4,
                               memories = 2, rank = 16, motion_inputs = 3, motion_hidden = 32,
                               motion_outputs = 1 + blocks;

  /// From the arrays of models/recurrent/weights.npz, which are in PyTorch's order. Throws InputError for an array that is
  /// missing, of another size, or not finite.
  explicit RecurrentModel(const ModelArrays& arrays);

  struct Memory {
    std::array<float, channels * rank> down;
    std::array<float, rank * channels> up;
    std::array<float, channels> up_bias;
    std::array<float, channels * channels> out;
  };
  std::array<float, 9 * inputs * first_channels> first;
  std::array<float, first_channels> first_bias;
  std::array<float, 9 * first_channels> second_depth;
  std::array<float, first_channels * channels> second_point;
  std::array<float, channels> second_bias;
  std::array<std::array<float, 9 * channels>, blocks> depth;
  std::array<std::array<float, channels * channels>, blocks> point;
  std::array<std::array<float, channels>, blocks> bias;
  std::array<Memory, memories> memory;
  std::array<float, motion_inputs * motion_hidden> motion_in;
  std::array<float, motion_hidden> motion_bias;
  std::array<float, motion_hidden * motion_outputs * channels> motion_out;
  std::array<float, channels * outputs> output;
  std::array<float, outputs> output_bias;
};

}  // namespace saccade
