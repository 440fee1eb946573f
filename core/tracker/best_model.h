#pragma once

#include <array>

#include "core/model_arrays.h"

namespace saccade {

/// The fitted numbers of DiscNetwork (core/tracker/disc_network.h): 3 x 3 taps row by row, then channels in, then channels out.
struct DiscNetworkWeights {
  static constexpr std::size_t inputs = 8, first_channels = 16, channels = 48, outputs = 4, blocks = 4;
  std::array<float, 9 * inputs * first_channels> first;
  std::array<float, first_channels> first_bias;
  std::array<float, 9 * first_channels> second_depth;
  std::array<float, first_channels * channels> second_point;
  std::array<float, channels> second_bias;
  std::array<std::array<float, 9 * channels>, blocks> block_depth;
  std::array<std::array<float, channels * channels>, blocks> block_point;
  std::array<std::array<float, channels>, blocks> block_bias;
  std::array<float, channels * outputs> output;
  std::array<float, outputs> output_bias;
};

/// Those of run_patch_network() (core/tracker/patch_network.h).
struct PatchNetworkWeights {
  static constexpr std::size_t inputs = 11, rings = 7, first_channels = 16, channels = 32, last_channels = 48,
                               hidden_units = 32, figures = 6, outputs = 3;
  std::array<float, 9 * inputs * first_channels> first;
  std::array<float, first_channels> first_bias;
  std::array<float, 9 * first_channels> depth_1;
  std::array<float, first_channels * channels> point_1;
  std::array<float, channels> point_bias_1;
  std::array<float, 9 * channels> depth_2, depth_3;
  std::array<float, channels * channels> point_2, point_3;
  std::array<float, channels> point_bias_2, point_bias_3;
  std::array<float, rings * channels * last_channels> across;
  std::array<float, last_channels> across_bias;
  std::array<float, 3 * last_channels> around_depth;
  std::array<float, last_channels * last_channels> around_point;
  std::array<float, last_channels> around_bias, offset;
  std::array<float, 1> offset_bias;
  std::array<float, figures> about_mean, about_scale;
  std::array<float, (2 * last_channels + figures) * hidden_units> hidden;
  std::array<float, hidden_units> hidden_bias;
  std::array<float, hidden_units * outputs> output;
  std::array<float, outputs> output_bias;
};

/// Those of disc_probability() (core/tracker/disc_probability.h).
struct DiscProbabilityWeights {
  static constexpr std::size_t inputs = 39, hidden_units = 224;
  std::array<float, inputs> input_mean, input_scale, direct_weight;
  std::array<std::array<float, hidden_units>, inputs> hidden_weight;
  std::array<float, hidden_units> hidden_bias, output_weight;
  std::array<float, 1> output_bias;
};

/// Those of run_track_network() (core/tracker/track_network.h).
struct TrackNetworkWeights {
  static constexpr std::size_t inputs = 185, features_of_step = 64, memory = 32;
  std::array<float, inputs> input_mean, input_scale;
  std::array<std::array<float, features_of_step>, inputs> features;
  std::array<float, features_of_step> features_bias;
  std::array<std::array<float, 3 * memory>, features_of_step> gates;
  std::array<float, 3 * memory> gates_bias;
  std::array<std::array<float, 3 * memory>, memory> recurrent;
  std::array<std::array<float, 2>, inputs> output_direct;
  std::array<std::array<float, 2>, features_of_step> output_features;
  std::array<std::array<float, 2>, memory> output_memory;
  std::array<float, 2> output_bias;
};

/// All fitted numbers of `best`: the arrays of models/best/weights.npz, whose manifest says where they come from.
struct BestModel {
  /// Throws InputError for an array that is missing, of another size, or not finite.
  explicit BestModel(const ModelArrays& arrays);

  DiscNetworkWeights disc;
  PatchNetworkWeights patch;
  DiscProbabilityWeights probability;
  TrackNetworkWeights track;
};

/// The arrays of models/best/weights.npz, as they were when the library was built.
[[nodiscard]] ModelArrays built_in_best_arrays();
/// Why BestModel refuses the arrays of a key; empty where it does not, and without arrays.
[[nodiscard]] std::string problem_of(const ModelFile& file);
/// The model of a key: its arrays, or the built-in ones where it has none. Throws InputError as BestModel does.
[[nodiscard]] std::shared_ptr<const BestModel> best_model_of(const ModelFile& file);

}  // namespace saccade
