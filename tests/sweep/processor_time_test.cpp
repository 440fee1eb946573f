#include "apps/sweep/processor_time.h"

#include <gtest/gtest.h>

#include "config/scenario.h"
#include "session/scenario_loop.h"
#include "tests/config/built_in.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

TEST(ProcessorTimes, AreThoseOfDetectorsInThisProcessAlone) {
  const TempFolder folder;
  const auto file = folder.write(
      "s.yaml",
      "name: s\nrun: {duration_s: 1}\nball: {trajectory: {kind: hold, points_m: [[-0.506, 0, 0.347]]}}\n"
      "detectors: {best: {}, cluster: {}}\ngaze: {detector: none}\n");
  const Scenario scenario = read_scenario(file, {}, std::nullopt, built_in());
  std::vector<LoopDetector> detectors = make_detectors(scenario.detectors, scenario.calibration.camera);
  ProcessorTimes times;
  times.measure(scenario, detectors);
  const std::vector<Event> events = {{.t_us = 1000, .x = 5, .y = 6, .on = true},
                                     {.t_us = 1010, .x = 6, .y = 6, .on = true}};
  detectors[0].detector->process(events, nullptr);
  detectors[0].detector->advance_to(2000, nullptr);
  EXPECT_EQ(detectors[0].detector->rejected().back_in_time, 0);
  detectors[0].detector->process(events, nullptr);
  EXPECT_EQ(detectors[0].detector->rejected().back_in_time, 1)
      << "calls reach the detector: the first is before the newest";
  Metrics metrics;
  metrics.event_count = 2;
  for (const char* name : {"best", "cluster", "other"})
    metrics.detectors.emplace_back(name, DetectorScore{}).second.us_per_event = -1.0;
  times.replace_costs(metrics);
  EXPECT_GT(metrics.detectors[0].second.us_per_event, 0.0);
  EXPECT_EQ(metrics.detectors[1].second.us_per_event, 0.0) << "it was not called";
  EXPECT_EQ(metrics.detectors[2].second.us_per_event, -1.0) << "nothing measured it";
}

}  // namespace
}  // namespace saccade
