// saccade calibrate as a user meets it: a short run of the board's scenario, and recordings that are too poor.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <string>

#include "tests/integration/run_shell.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

using testing::HasSubstr;

const std::string source = SACCADE_SOURCE_DIR;

Outcome saccade(const std::string& arguments) { return run_shell("'" SACCADE_BINARY "' " + arguments); }

/// The first number of a key in a calibration's file.
double number_of(const std::string& yaml, const std::string& key) {
  const std::size_t at = yaml.find(" " + key + ": ");
  return at == std::string::npos ? std::nan("") : std::stod(yaml.substr(at + key.size() + 3));
}

TEST(Calibrate, AShortRunBeforeTheBoardGivesTheLensAndAScenarioTakesIt) {
  const TempFolder folder;
  const std::string run = (folder / "run").string();
  const std::string yaml = (folder / "left.yaml").string();
  const Outcome made =
      saccade("run '" + source +
              "/scenarios/calibrate_left.yaml' --set run.duration_s=9.5 --set board.rest_s=2.7 "
              "--set render.supersampling=2 --set output.pictures=0 --set lab.density=0 --out " +
              run);
  ASSERT_EQ(made.status, 0) << made.text;
  const Outcome found = saccade("calibrate " + run + " --no_joints --max_speed_px_s 60 --out " + yaml);
  ASSERT_EQ(found.status, 0) << found.text;
  std::printf("%s", found.text.c_str());
  const std::string text = bytes_of(yaml);
  // A fifth of the scenario: three times what is asked of the whole.
  EXPECT_NEAR(number_of(text, "fx_px"), 99.45, 0.03 * 99.45);
  EXPECT_NEAR(number_of(text, "fy_px"), 99.75, 0.03 * 99.75);
  EXPECT_NEAR(number_of(text, "cx_px"), 64.0, 3.0);
  EXPECT_NEAR(number_of(text, "cy_px"), 69.18, 3.0);
  EXPECT_THAT(found.text, HasSubstr("no joints were used"));

  const Outcome again = saccade("calibrate " + run + " --no_joints --out " + yaml);
  EXPECT_EQ(again.status, 2);
  EXPECT_THAT(again.text, HasSubstr("a file that exists"));
  EXPECT_EQ(bytes_of(yaml), text);

  const Outcome used = saccade("run '" + source + "/scenarios/look_at_ball.yaml' --set run.duration_s=0.05 " +
                               "--set expect={} --set output.pictures=0 --set calibration.file=" + yaml +
                               " --out " + (folder / "used").string());
  ASSERT_EQ(used.status, 0) << used.text;
  const std::string resolved = bytes_of(folder / "used/scenario.yaml");
  EXPECT_EQ(number_of(resolved.substr(resolved.find("\ncalibration:")), "fx_px"), number_of(text, "fx_px"));
}

TEST(Calibrate, ARecordingWithoutAGridIsRejectedWithOneLine) {
  const TempFolder folder;
  const std::string yaml = (folder / "left.yaml").string();
  const std::string run = (folder / "run").string();
  const Outcome made = saccade("run '" + source + "/scenarios/look_at_ball.yaml' --set run.duration_s=0.5 " +
                               "--set expect={} --set output.pictures=0 --out " + run);
  ASSERT_EQ(made.status, 0) << made.text;
  const Outcome ball = saccade("calibrate " + run + "/events.aedat --out " + yaml);
  EXPECT_EQ(ball.status, 1);
  EXPECT_THAT(ball.text, HasSubstr("found in 0 images"));
  EXPECT_FALSE(std::filesystem::exists(yaml));
  const Outcome even = saccade("calibrate nothing --grid 4x6 --out " + yaml);
  EXPECT_EQ(even.status, 2);
  EXPECT_THAT(even.text, HasSubstr("odd number of rows"));
}

}  // namespace
}  // namespace saccade
