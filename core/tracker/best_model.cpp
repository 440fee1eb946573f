#include "core/tracker/best_model.h"

#include "core/error.h"

namespace saccade {
namespace {

template <std::size_t n>
void copy(const ModelArrays& from, std::string_view name, std::array<float, n>& to) {
  from.copy(name, to);
}
template <std::size_t n, std::size_t m>
void copy(const ModelArrays& from, std::string_view name, std::array<std::array<float, m>, n>& to) {
  from.copy(name, {to[0].data(), n * m});
}

}  // namespace

BestModel::BestModel(const ModelArrays& a) {
  copy(a, "disc.first", disc.first);
  copy(a, "disc.first_bias", disc.first_bias);
  copy(a, "disc.second_depth", disc.second_depth);
  copy(a, "disc.second_point", disc.second_point);
  copy(a, "disc.second_bias", disc.second_bias);
  copy(a, "disc.block_depth", disc.block_depth);
  copy(a, "disc.block_point", disc.block_point);
  copy(a, "disc.block_bias", disc.block_bias);
  copy(a, "disc.output", disc.output);
  copy(a, "disc.output_bias", disc.output_bias);

  copy(a, "patch.first", patch.first);
  copy(a, "patch.first_bias", patch.first_bias);
  copy(a, "patch.depth_1", patch.depth_1);
  copy(a, "patch.point_1", patch.point_1);
  copy(a, "patch.point_bias_1", patch.point_bias_1);
  copy(a, "patch.depth_2", patch.depth_2);
  copy(a, "patch.point_2", patch.point_2);
  copy(a, "patch.point_bias_2", patch.point_bias_2);
  copy(a, "patch.depth_3", patch.depth_3);
  copy(a, "patch.point_3", patch.point_3);
  copy(a, "patch.point_bias_3", patch.point_bias_3);
  copy(a, "patch.across", patch.across);
  copy(a, "patch.across_bias", patch.across_bias);
  copy(a, "patch.around_depth", patch.around_depth);
  copy(a, "patch.around_point", patch.around_point);
  copy(a, "patch.around_bias", patch.around_bias);
  copy(a, "patch.offset", patch.offset);
  copy(a, "patch.offset_bias", patch.offset_bias);
  copy(a, "patch.about_mean", patch.about_mean);
  copy(a, "patch.about_scale", patch.about_scale);
  copy(a, "patch.hidden", patch.hidden);
  copy(a, "patch.hidden_bias", patch.hidden_bias);
  copy(a, "patch.output", patch.output);
  copy(a, "patch.output_bias", patch.output_bias);

  copy(a, "probability.input_mean", probability.input_mean);
  copy(a, "probability.input_scale", probability.input_scale);
  copy(a, "probability.direct_weight", probability.direct_weight);
  copy(a, "probability.hidden_weight", probability.hidden_weight);
  copy(a, "probability.hidden_bias", probability.hidden_bias);
  copy(a, "probability.output_weight", probability.output_weight);
  copy(a, "probability.output_bias", probability.output_bias);

  copy(a, "track.input_mean", track.input_mean);
  copy(a, "track.input_scale", track.input_scale);
  copy(a, "track.features", track.features);
  copy(a, "track.features_bias", track.features_bias);
  copy(a, "track.gates", track.gates);
  copy(a, "track.gates_bias", track.gates_bias);
  copy(a, "track.recurrent", track.recurrent);
  copy(a, "track.output_direct", track.output_direct);
  copy(a, "track.output_features", track.output_features);
  copy(a, "track.output_memory", track.output_memory);
  copy(a, "track.output_bias", track.output_bias);
}

std::string problem_of(const ModelFile& file) {
  if (file.arrays == nullptr) return {};
  try {
    static_cast<void>(BestModel(*file.arrays));
    return {};
  } catch (const InputError& error) {
    return file.path + ", " + error.what();
  }
}

std::shared_ptr<const BestModel> best_model_of(const ModelFile& file) {
  return std::make_shared<const BestModel>(file.arrays != nullptr ? *file.arrays : built_in_best_arrays());
}

}  // namespace saccade
