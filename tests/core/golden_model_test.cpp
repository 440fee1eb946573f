// The networks of `best` against PyTorch: models/best/golden.npz.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/tracker/best_model.h"
#include "core/tracker/disc_network.h"
#include "core/tracker/disc_probability.h"
#include "core/tracker/patch_network.h"
#include "core/tracker/track_network.h"
#include "recording/model_file.h"

namespace saccade {
namespace {

class GoldenModel : public testing::Test {
 protected:
  [[nodiscard]] std::vector<float> golden(std::string_view name, std::size_t count) const {
    std::vector<float> values(count);
    golden_.copy(name, values);
    return values;
  }
  static void expect_near(double found, double expected, std::string_view what) {
    EXPECT_NEAR(found, expected, 1e-5 * std::max(1.0, std::abs(expected))) << what;
  }

  ModelArrays golden_ = read_model(SACCADE_SOURCE_DIR "/models/best/golden.npz");
  BestModel model_{read_model(SACCADE_SOURCE_DIR "/models/best/weights.npz")};
};

TEST_F(GoldenModel, TheBuiltInWeightsAreThoseOfTheFile) {
  const BestModel built_in(built_in_best_arrays());
  EXPECT_EQ(built_in.disc.block_point, model_.disc.block_point);
  EXPECT_EQ(built_in.patch.across, model_.patch.across);
  EXPECT_EQ(built_in.probability.hidden_weight, model_.probability.hidden_weight);
  EXPECT_EQ(built_in.track.features, model_.track.features);
}

TEST_F(GoldenModel, JudgesPatchesAsPyTorchDoes) {
  constexpr std::size_t patches = 4,
                        values = PolarPatch::directions * PolarPatch::rings * PolarPatch::channels;
  const std::vector<float> inputs = golden("patch.values", patches * values),
                           about = golden("patch.about", patches * PolarPatch::figures),
                           ring_px = golden("patch.ring_px", patches),
                           outputs = golden("patch.output", patches * 6);
  for (std::size_t i = 0; i < patches; ++i) {
    PolarPatch patch;
    std::copy_n(inputs.begin() + static_cast<std::ptrdiff_t>(i * values), values, patch.values.begin());
    std::copy_n(about.begin() + static_cast<std::ptrdiff_t>(i * patch.about.size()), patch.about.size(),
                patch.about.begin());
    patch.ring_px = static_cast<double>(ring_px[i]);
    const PatchOutput found = run_patch_network(model_.patch, patch);
    const float* expected = &outputs[i * 6];
    expect_near(found.log_odds, expected[0], "log odds");
    expect_near(found.correction.x_px, expected[1], "x");
    expect_near(found.correction.y_px, expected[2], "y");
    expect_near(found.correction.r_px, expected[3], "r");
    expect_near(found.centre_sd_px, expected[4], "deviation of the centre");
    expect_near(found.radius_sd_px, expected[5], "deviation of the radius");
  }
}

TEST_F(GoldenModel, GivesTheProbabilitiesOfPyTorch) {
  constexpr std::size_t rows = 6;
  const std::vector<float> inputs = golden("probability.inputs", rows * disc_input_count),
                           outputs = golden("probability.output", rows);
  for (std::size_t i = 0; i < rows; ++i) {
    DiscInputs row;
    std::copy_n(inputs.begin() + static_cast<std::ptrdiff_t>(i * row.size()), row.size(), row.begin());
    expect_near(disc_probability(model_.probability, row), outputs[i], "probability");
  }
}

TEST_F(GoldenModel, RemembersATrackAsPyTorchDoes) {
  constexpr std::size_t steps = 12;
  const std::vector<float> inputs = golden("track.inputs", steps * track_input_count),
                           probability = golden("track.probability", steps),
                           leaves_per_s = golden("track.leaves_per_s", steps);
  TrackMemory memory{};
  for (std::size_t i = 0; i < steps; ++i) {
    TrackInputs row;
    std::copy_n(inputs.begin() + static_cast<std::ptrdiff_t>(i * row.size()), row.size(), row.begin());
    const TrackExistence found = run_track_network(model_.track, row, memory);
    expect_near(found.probability, probability[i], "probability");
    expect_near(found.leaves_per_s, leaves_per_s[i], "rate of leaving");
  }
}

TEST_F(GoldenModel, FindsTheDiscThatPyTorchFinds) {
  constexpr ImageSize size{64, 64};
  constexpr std::int64_t now_us = 1'000'000;
  const std::vector<float> age_us = golden("disc.age_us", 2 * 64 * 64), best = golden("disc.best", 4);
  TimeSurface surface(size);
  DiscNetwork network(std::make_shared<const BestModel>(model_), size, 4, 16);
  for (std::size_t i = 0; i < age_us.size(); ++i) {
    if (age_us[i] < 0) continue;  // no event
    const std::size_t pixel = i % (64 * 64);
    surface.add({now_us - static_cast<std::int64_t>(age_us[i]), static_cast<std::uint16_t>(pixel % 64),
                 static_cast<std::uint16_t>(pixel / 64), i < 64 * 64, 0});
  }
  network.begin(now_us);
  ASSERT_TRUE(network.work(surface, 1'000'000'000));
  ASSERT_FALSE(network.found().empty());
  const DiscNetwork::Found found = network.found().front();
  expect_near(found.log_odds, best[0], "log odds");
  expect_near(found.circle.x_px, best[1], "x");
  expect_near(found.circle.y_px, best[2], "y");
  expect_near(found.circle.r_px, best[3], "r");
}

}  // namespace
}  // namespace saccade
