#include "core/model_arrays.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <limits>

#include "core/error.h"

namespace saccade {
namespace {

TEST(ModelArrays, CopyAnArrayByName) {
  ModelArrays arrays;
  arrays.add("a", {1.0F, 2.0F});
  arrays.add("b", {3.0F});
  std::array<float, 2> to{};
  arrays.copy("a", to);
  EXPECT_THAT(to, testing::ElementsAre(1.0F, 2.0F));
}

TEST(ModelArrays, RefuseWhatIsMissingTwiceOfAnotherSizeOrNotFinite) {
  ModelArrays arrays;
  arrays.add("a", {1.0F, 2.0F});
  arrays.add("nan", {std::numeric_limits<float>::quiet_NaN()});
  std::array<float, 1> one{};
  std::array<float, 3> three{};
  EXPECT_THROW(arrays.add("a", {1.0F}), InputError);
  EXPECT_THROW(arrays.copy("b", one), InputError);
  EXPECT_THROW(arrays.copy("a", one), InputError);
  EXPECT_THROW(arrays.copy("a", three), InputError);
  EXPECT_THROW(arrays.copy("nan", one), InputError);
}

}  // namespace
}  // namespace saccade
