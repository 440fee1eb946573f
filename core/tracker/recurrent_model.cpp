#include "core/tracker/recurrent_model.h"

#include <string>
#include <vector>

namespace saccade {
namespace {

/// An array of PyTorch (channels out x channels in x taps) as taps x channels in x channels out.
template <std::size_t n>
void copy(const ModelArrays& arrays, const std::string& name, std::size_t out, std::size_t taps,
          std::array<float, n>& to) {
  std::vector<float> from(n);
  arrays.copy(name, from);
  const std::size_t in = n / (out * taps);
  for (std::size_t o = 0; o < out; ++o) {
    for (std::size_t i = 0; i < in; ++i) {
      for (std::size_t t = 0; t < taps; ++t) to[(t * in + i) * out + o] = from[(o * in + i) * taps + t];
    }
  }
}

}  // namespace

RecurrentModel::RecurrentModel(const ModelArrays& a) {
  copy(a, "first.weight", first_channels, 9, first);
  a.copy("first.bias", first_bias);
  copy(a, "second_depth.weight", first_channels, 9, second_depth);
  copy(a, "second_point.weight", channels, 1, second_point);
  a.copy("second_point.bias", second_bias);
  for (std::size_t n = 0; n < blocks; ++n) {
    const std::string number = std::to_string(n);
    copy(a, "depth." + number + ".weight", channels, 9, depth[n]);
    copy(a, "point." + number + ".weight", channels, 1, point[n]);
    a.copy("point." + number + ".bias", bias[n]);
  }
  for (std::size_t n = 0; n < memories; ++n) {
    const std::string prefix = "memory." + std::to_string(n);
    copy(a, prefix + ".down.weight", rank, 1, memory[n].down);
    copy(a, prefix + ".up.weight", channels, 1, memory[n].up);
    a.copy(prefix + ".up.bias", memory[n].up_bias);
    copy(a, prefix + ".out.weight", channels, 1, memory[n].out);
  }
  copy(a, "motion.0.weight", motion_hidden, 1, motion_in);
  a.copy("motion.0.bias", motion_bias);
  copy(a, "motion.2.weight", motion_outputs * channels, 1, motion_out);
  copy(a, "output.weight", outputs, 1, output);
  a.copy("output.bias", output_bias);
}

}  // namespace saccade
