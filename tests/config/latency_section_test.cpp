// The section `latency` of a scenario and the file of processing times.
#include "config/latency_section.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/scenario.h"
#include "recording/output_file.h"
#include "tests/config/built_in.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

Scenario read(const TempFolder& folder, const std::string& latency) {
  write_file(folder / "s.yaml",
             "name: s\nrun: {duration_s: 1}\nball: {trajectory: {kind: hold, points_m: [[-0.4, 0, 0.4]]}}\n"
             "detectors: {best: {}, fast: {preset: paper_directed}}\ngaze: {detector: best}\n" +
                 latency);
  return read_scenario(folder / "s.yaml", {}, std::nullopt, built_in());
}

std::vector<double> per_call_us(const LatencyConfig& latency) {
  std::vector<double> times;
  for (const auto& [name, work] : latency.detectors) times.push_back(work.per_call_us);
  return times;
}

TEST(LatencySection, IsNoneByDefaultAndThenHasOneKey) {
  const TempFolder folder;
  const Scenario scenario = read(folder, "");
  EXPECT_EQ(scenario.latency.kind, LatencyKind::none);
  EXPECT_THAT(resolved_scenario(scenario), HasSubstr("latency:\n  kind: none\n"));
  EXPECT_THAT(resolved_scenario(scenario), Not(HasSubstr("transport_ms")));
}

TEST(LatencySection, TakesTheTimesOfAFileByDetectorOrPresetAndItsOwnKeysWin) {
  const TempFolder folder;
  LatencyConfig fitted;
  fitted.controller_us = 4.0;
  fitted.detectors = {{"paper_directed", {0.5, 7.0}}, {"best", {0.2, 90.0}}, {"other", {9.0, 9.0}}};
  write_file(folder / "machine.yaml", latency_yaml(fitted));
  const Scenario scenario =
      read(folder, "latency: {kind: model, file: machine.yaml, detectors: {best: {per_event_us: 1.5}}}\n");
  EXPECT_EQ(scenario.latency.controller_us, 4.0);
  EXPECT_THAT(per_call_us(scenario.latency), ElementsAre(90.0, 7.0));
  EXPECT_EQ(scenario.latency.work_of("best").per_event_us, 1.5);
  EXPECT_EQ(scenario.latency.work_of("fast").per_event_us, 0.5);
}

TEST(LatencySection, ReadsBackAsItWasResolved) {
  const TempFolder folder;
  const Scenario scenario = read(
      folder,
      "latency: {kind: model, transport_ms: 2, actuation_ms: 15, detectors: {fast: {per_call_us: 3}}}\n");
  write_file(folder / "resolved.yaml", resolved_scenario(scenario));
  const Scenario again = read_scenario(folder / "resolved.yaml", {}, std::nullopt, built_in());
  EXPECT_EQ(resolved_scenario(again), resolved_scenario(scenario));
  EXPECT_THAT(per_call_us(again.latency), ElementsAre(0.0, 3.0));
  EXPECT_EQ(again.latency.actuation_ms, 15.0);
}

TEST(LatencySection, RefusesADetectorThatTheScenarioDoesNotHave) {
  const TempFolder folder;
  EXPECT_THROW((void)read(folder, "latency: {kind: model, detectors: {nobody: {per_call_us: 3}}}\n"),
               InputError);
}

TEST(LatencySection, RefusesProcessingTimesWhereTheyAreMeasured) {
  const TempFolder folder;
  EXPECT_THROW((void)read(folder, "latency: {kind: measured, controller_us: 3}\n"), InputError);
  EXPECT_EQ(read(folder, "latency: {kind: measured, transport_ms: 3}\n").latency.transport_us(), 3000);
}

}  // namespace
}  // namespace saccade
