#include "evaluation/report/eye_movement_section.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

using testing::HasSubstr;
using testing::Not;

EyeMovementScore pursuing(double frequency_hz, double gain) {
  EyeMovementScore score;
  score.pursuit = Transfer{frequency_hz, gain, -10.0};
  score.error_deg.median = 0.5;
  return score;
}

TEST(EyeMovementSection, TheTableHasTheFiguresThatARunHasAndNoOthers) {
  const EyeMovementScore score = pursuing(1.0, 0.96);
  const EyeMovementColumn column{"", &score};
  const std::string html = eye_movement_table({&column, 1});
  EXPECT_THAT(html, HasSubstr("pursuit: gain"));
  EXPECT_THAT(html, HasSubstr("0.96"));
  EXPECT_THAT(html, HasSubstr("gaze error, median"));
  EXPECT_THAT(html, Not(HasSubstr("slip reduction")));
  EXPECT_THAT(html, Not(HasSubstr("ramps")));
}

TEST(EyeMovementSection, TheBodePlotJoinsTheFrequenciesOfALabel) {
  TempFolder folder;
  const EyeMovementScore slow = pursuing(0.5, 1.0);
  const EyeMovementScore fast = pursuing(2.0, 0.75);
  const EyeMovementScore other = pursuing(1.0, 0.5);
  const std::vector<EyeMovementColumn> columns = {{"one", &slow}, {"one", &fast}, {"two", &other}};
  const std::string html = bode_figures(columns, FigureFolder(folder / "page"));
  EXPECT_THAT(html, HasSubstr("Pursuit over frequency"));
  EXPECT_THAT(html, Not(HasSubstr("Stabilisation over frequency")));
  const std::string csv = bytes_of(folder / "page/figures/bode_pursuit.csv");
  EXPECT_THAT(csv, HasSubstr("one,0.5,1"));
  EXPECT_THAT(csv, HasSubstr("one,2,0.75"));
  EXPECT_THAT(csv, Not(HasSubstr("two")));
}

TEST(EyeMovementSection, ASingleFrequencyMakesNoBodePlot) {
  TempFolder folder;
  const EyeMovementScore score = pursuing(1.0, 1.0);
  const EyeMovementColumn column{"one", &score};
  EXPECT_EQ(bode_figures({&column, 1}, FigureFolder(folder / "page")), "");
}

}  // namespace
}  // namespace saccade
