// The recurrent network against PyTorch: models/recurrent/golden.npz.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/tracker/recurrent_level.h"
#include "recording/model_file.h"

namespace saccade {
namespace {

constexpr std::size_t steps = 12, cells = 32, squares = 8, channels = RecurrentModel::channels;
constexpr float dt_ms = 5.0F;

/// Value of an array of channels x rows x columns.
float at(const std::vector<float>& values, std::size_t first, std::size_t channel, std::size_t place,
         std::size_t places) {
  return values[first + channel * places + place];
}

void expect_near(float found, float expected, std::size_t step, std::size_t channel) {
  EXPECT_NEAR(found, expected, 1e-5F * std::max(1.0F, std::abs(expected)))
      << "step " << step << ", channel " << channel;
}

TEST(RecurrentLevel, GivesTheOutputsOfPyTorchStepByStep) {
  const ModelArrays golden = read_model(SACCADE_SOURCE_DIR "/models/recurrent/golden.npz");
  const auto array = [&](std::string_view name, std::size_t count) {
    std::vector<float> values(count);
    golden.copy(name, values);
    return values;
  };
  const std::vector<float> inputs = array("inputs", steps * RecurrentModel::inputs * cells * cells),
                           shift = array("shift", steps * 2), motion = array("motion", steps * 3),
                           outputs = array("outputs", steps * RecurrentModel::outputs * squares * squares);
  const std::array memories = {array("memory_0", channels * squares * squares),
                               array("memory_1", channels * squares * squares)};
  RecurrentLevel level(
      std::make_shared<const RecurrentModel>(read_model(SACCADE_SOURCE_DIR "/models/recurrent/weights.npz")),
      cells, cells);
  RecurrentLevel::Maps maps;
  maps.reserve(cells, cells);
  for (std::size_t t = 0; t < steps; ++t) {
    for (std::size_t p = 0; p < cells * cells; ++p) {
      for (std::size_t c = 0; c < RecurrentModel::inputs; ++c)
        level.input()[p * RecurrentModel::inputs + c] =
            at(inputs, t * RecurrentModel::inputs * cells * cells, c, p, cells * cells);
    }
    const bool known = motion[3 * t + 2] != 0.0F;
    const auto speed = [&](std::size_t i) { return known ? shift[2 * t + i] * (100.0F / dt_ms) : 0.0F; };
    level.begin({dt_ms,
                 static_cast<int>(shift[2 * t]),
                 static_cast<int>(shift[2 * t + 1]),
                 {speed(0), speed(1)},
                 known});
    while (level.row(maps) > 0) {
    }
    for (std::size_t p = 0; p < squares * squares; ++p) {
      const RecurrentLevel::Square& s = level.output()[p];
      const std::array found = {
          s.log_odds,       s.x, s.y, s.log2_radius, s.vx, s.vy, s.log_sd_centre, s.log_sd_log2_radius,
          s.inlier_log_odds};
      for (std::size_t c = 0; c < found.size(); ++c)
        expect_near(found[c], at(outputs, t * found.size() * squares * squares, c, p, squares * squares), t,
                    c);
    }
  }
  for (std::size_t n = 0; n < memories.size(); ++n) {
    for (std::size_t p = 0; p < squares * squares; ++p) {
      for (std::size_t c = 0; c < channels; ++c)
        expect_near(level.memory(n)[p * channels + c], at(memories[n], 0, c, p, squares * squares), steps, c);
    }
  }
}

}  // namespace
}  // namespace saccade
