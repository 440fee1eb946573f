#include "recording/model_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "core/error.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

using testing::HasSubstr;

const std::string shipped = SACCADE_SOURCE_DIR "/models/best/weights.npz";

std::string error_of(const std::filesystem::path& path) {
  try {
    static_cast<void>(read_model(path));
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

std::string bytes_of(const std::filesystem::path& path) {
  std::ostringstream bytes;
  bytes << std::ifstream(path, std::ios::binary).rdbuf();
  return bytes.str();
}

TEST(ModelFile, ReadsTheArraysOfTheShippedModel) {
  const ModelArrays model = read_model(shipped);
  std::array<float, 4> bias{};
  model.copy("disc.output_bias", bias);
  EXPECT_NE(bias[0], 0.0F);
}

TEST(ModelFile, NamesAnArrayThatIsMissingOrOfAnotherSize) {
  const ModelArrays model = read_model(shipped);
  std::array<float, 3> three{};
  EXPECT_THROW(model.copy("disc.output_bias", three), InputError);
  EXPECT_THROW(model.copy("disc.last", three), InputError);
}

TEST(ModelFile, RefusesWhatIsNoModel) {
  const TempFolder folder;
  EXPECT_THAT(error_of(folder / "none.npz"), HasSubstr("none.npz"));
  std::ofstream(folder / "text.npz") << "weights";
  EXPECT_THAT(error_of(folder / "text.npz"), HasSubstr("expected an NPZ file"));
}

TEST(ModelFile, RefusesATornAndADamagedFile) {
  const TempFolder folder;
  const std::string whole = bytes_of(shipped);
  ASSERT_GT(whole.size(), 100'000U);
  std::ofstream(folder / "torn.npz", std::ios::binary) << whole.substr(0, whole.size() / 2);
  EXPECT_NE(error_of(folder / "torn.npz"), "");
  std::string damaged = whole;
  damaged[whole.size() / 2] ^= 1;
  std::ofstream(folder / "damaged.npz", std::ios::binary) << damaged;
  EXPECT_NE(error_of(folder / "damaged.npz"), "");
}

}  // namespace
}  // namespace saccade
