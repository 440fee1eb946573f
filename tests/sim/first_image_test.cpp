#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <iostream>
#include <memory>
#include <numeric>
#include <string>
#include <vector>

#include "core/error.h"
#include "head/icub_cameras.h"
#include "sim/keyframe_renderer.h"
#include "sim/lab.h"
#include "sim/world.h"

// The first images of two worlds against stored ones of MuJoCo 2.2.2. With every version of MuJoCo and Mesa the means of
// their parts are equal within a grey level; with the versions of Debian 12 the bytes are equal.

namespace saccade {
namespace {

constexpr const char* golden_mujoco = "2.2.2";
constexpr const char* golden_opengl =
    "llvmpipe (LLVM 15.0.6, 256 bits), 4.5 (Compatibility Profile) Mesa 22.3.6";
constexpr int columns = 8;
constexpr int rows = 6;
using Parts = std::array<double, static_cast<std::size_t>(columns* rows)>;

struct FirstImages {
  std::vector<float> direct;
  std::vector<float> keyframes;
};

class FirstImage : public testing::Test {
 protected:
  void SetUp() override {
    try {
      gl_ = GlContext::create("auto");
    } catch (const RunError& error) {
      GTEST_SKIP() << "NOT TESTED, there is no OpenGL: " << error.what();
    }
  }
  FirstImages draw(const WorldConfig& config, const LabConfig& lab_config) {
    const Lab lab(lab_config, 1);
    World world(config, lab.mjcf(), 1);
    lab.paint(world.model());
    const auto pixels = static_cast<std::size_t>(camera_.size.pixels());
    FirstImages images{std::vector<float>(pixels), std::vector<float>(pixels)};
    EyeRenderer(world.model(), *gl_, camera_, {})
        .render(world.data(), world.left_eye_camera(), images.direct);
    KeyframeRenderer(world.model(), *gl_, camera_, {}, std::make_shared<WorkerThreads>(1))
        .render(world.data(), world.left_eye_camera(), images.keyframes);
    return images;
  }
  /// Means of 8 x 6 equal parts.
  [[nodiscard]] Parts parts(const std::vector<float>& image) const {
    const int width = camera_.size.width / columns;
    const int height = camera_.size.height / rows;
    Parts means{};
    for (int y = 0; y < rows * height; ++y) {
      for (int x = 0; x < columns * width; ++x) {
        means[static_cast<std::size_t>(y / height * columns + x / width)] +=
            static_cast<double>(image[static_cast<std::size_t>(y * camera_.size.width + x)]) /
            (width * height);
      }
    }
    return means;
  }
  void expect_golden(const FirstImages& images, const Parts& means, std::uint64_t hash) const {
    const auto text_of = [](const Parts& parts) {
      std::string text;
      for (const double mean : parts)
        text += std::to_string(std::round(10.0 * mean) / 10.0).substr(0, 5) + ", ";
      return text;
    };
    const auto compare = [&](const std::vector<float>& image, double tolerance) {
      const Parts found = parts(image);
      EXPECT_THAT(found, testing::Pointwise(testing::DoubleNear(tolerance), means))
          << "made with MuJoCo " << golden_mujoco << ", this is MuJoCo " << mj_versionString() << ", "
          << gl_->description() << ": " << text_of(found);
    };
    compare(images.direct, 1.0);
    compare(images.keyframes, 4.0);  // finer samples
    std::uint64_t found = 1469598103934665603ULL;
    for (const std::vector<float>* image : {&images.direct, &images.keyframes}) {
      for (const float value : *image) {
        for (const unsigned char byte : std::bit_cast<std::array<unsigned char, sizeof value>>(value))
          found = (found ^ byte) * 1099511628211ULL;
      }
    }
    if (mj_versionString() == std::string(golden_mujoco) && gl_->description().ends_with(golden_opengl)) {
      EXPECT_EQ(found, hash) << std::hex << found;
    } else {
      std::cout << "NOT COMPARED: bytes, which were made with MuJoCo " << golden_mujoco << " and "
                << golden_opengl << "; this is MuJoCo " << mj_versionString() << " and " << gl_->description()
                << "\n";
    }
  }

  Camera camera_ = icub_left_2016;
  std::unique_ptr<GlContext> gl_;
};

TEST_F(FirstImage, OfAGlossyPatternedBallInAHandWithACheckedSleeveBeforeATexturedLab) {
  WorldConfig config;
  config.ball.pattern = BallPattern::patches;
  config.ball.gloss = 0.5;
  config.ball.sleeve = Sleeve::checked;
  constexpr Parts means = {114.3, 121.5, 111.3, 93.9,  107.1, 108.2, 70.9,  69.6,  84.5, 86.1, 88.2, 91.7,
                           113.8, 105.9, 94.4,  92,    99.5,  108.2, 104.7, 106.5, 98,   78.9, 92.5, 96.1,
                           74.1,  89.3,  101.1, 96.1,  63.6,  80.6,  96.9,  131.8, 75.4, 89.6, 81.4, 95.3,
                           100.5, 100.2, 79.9,  113.6, 130,   103.3, 109.4, 116.1, 86.7, 94.8, 91.6, 96.5};
  expect_golden(draw(config, {.clutter = Clutter::textured}), means, 0xdda6be3b070f9732ULL);
}

TEST_F(FirstImage, OfABallOnAPalmBeforeARectilinearLab) {
  WorldConfig config;
  config.ball.hand = Hand::palm;
  constexpr Parts means = {68.3,  80.1,  93.3,  97.7,  102.5, 127.7, 134.3, 145.1, 62.4, 83.2,
                           93.6,  112.3, 110.9, 168.7, 172.4, 128.2, 76.1,  83.9,  94.8, 113.7,
                           103.3, 93.8,  77.9,  67.1,  80.2,  78.7,  85,    103,   75.9, 99.5,
                           99.5,  100.8, 82.5,  82,    84.8,  67.9,  80.9,  77.9,  90.1, 96,
                           102.8, 109.7, 115.7, 101.2, 106.8, 115.5, 119.4, 103.4};
  expect_golden(draw(config, {.clutter = Clutter::rectilinear}), means, 0xa22c2db6a141cee9ULL);
}

}  // namespace
}  // namespace saccade
