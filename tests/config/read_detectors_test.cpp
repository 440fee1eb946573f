// `--set` of saccade detect: one key for all detectors that have it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "config/scenario.h"
#include "core/baselines/original_2016.h"
#include "core/detectors/built_in_detectors.h"
#include "core/hough/hough_detector.h"

namespace saccade {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

class ReadDetectors : public testing::Test {
 protected:
  ReadDetectors() : path_(testing::TempDir() + "/detectors_" + std::to_string(::getpid()) + ".yaml") {
    std::ofstream file(path_);
    file << "detectors:\n";
    for (const std::string& name : built_in_detectors().names()) file << "  " << name << ": {}\n";
  }
  ~ReadDetectors() override { std::filesystem::remove(path_); }

  [[nodiscard]] NamedDetectors read(const std::vector<std::string>& assignments) const {
    return read_detectors(path_, assignments, built_in_detectors());
  }
  [[nodiscard]] std::string message(const std::vector<std::string>& assignments) const {
    try {
      static_cast<void>(read(assignments));
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  }

 private:
  std::string path_;
};

const HoughDetectorConfig& hough(const NamedDetectors& detectors, const std::string& name) {
  for (const auto& [known, config] : detectors) {
    if (known == name) return config.get<HoughDetectorConfig>();
  }
  throw RunError("no detector " + name);
}

TEST_F(ReadDetectors, WithoutAFileAreTheDefaultOnes) {
  const NamedDetectors detectors = read_detectors("", {"radius_px=[4, 25]"}, built_in_detectors());
  ASSERT_EQ(detectors.size(), built_in_detectors().defaults.size());
  for (std::size_t i = 0; i < detectors.size(); ++i) {
    EXPECT_EQ(detectors[i].first, built_in_detectors().defaults[i]);
    EXPECT_EQ(detectors[i].second.preset(), built_in_detectors().defaults[i]);
  }
  EXPECT_THAT(hough(detectors, "paper_full").radius_px, ElementsAre(4, 25));
}

TEST_F(ReadDetectors, ARangeOfRadiiHoldsForEveryPreset) {
  for (const auto& [name, config] : read({"radius_px=[4,25]"})) {
    EXPECT_THAT(resolved_detectors({{name, config}}), HasSubstr("radius_px: [4, 25]"));
  }
}

TEST_F(ReadDetectors, AKeyHoldsForThoseThatHaveIt) {
  const NamedDetectors detectors = read({"window.events=700", "arc_deg=7", "single_radius.window.events=33"});
  EXPECT_EQ(hough(detectors, "paper_full").window.events, 700);
  EXPECT_EQ(hough(detectors, "paper_directed").arc_deg, 7.0);
  EXPECT_EQ(hough(detectors, "single_radius").window.events, 33);  // the last one wins
  EXPECT_EQ(detectors[5].second.get<Original2016Config>().window_events, 700);
  EXPECT_EQ(detectors[5].second.get<Original2016Config>().arc_deg, 7.0);
}

TEST_F(ReadDetectors, AKeyThatAnotherBringsMayStandBeforeIt) {
  for (const auto& order : {std::vector<std::string>{"window.kind=time", "window.duration_us=7000"},
                            std::vector<std::string>{"window.duration_us=7000", "window.kind=time"}}) {
    const NamedDetectors detectors = read(order);
    EXPECT_EQ(hough(detectors, "paper_full").window.kind, WindowKind::time);
    EXPECT_EQ(hough(detectors, "paper_full").window.duration_us, 7000);
  }
}

TEST_F(ReadDetectors, AKeyThatNoneHasIsAnError) {
  EXPECT_THAT(message({"windows.events=700"}),
              HasSubstr("windows: found an unknown key, expected a known key; did you mean window?"));
  EXPECT_THAT(message({"window.duration_us=7000"}), HasSubstr("duration_us"));
  EXPECT_THAT(message({"paper_full.arc_deg=7"}), HasSubstr("detectors.paper_full.arc_deg"));
  EXPECT_THAT(message({"radius_px"}), HasSubstr("key.path=value"));
}

TEST_F(ReadDetectors, AWrongValueIsAnErrorOfThoseThatHaveTheKeyAlone) {
  EXPECT_THAT(message({"arc_deg=700"}), AllOf(HasSubstr("detectors.paper_directed.arc_deg"),
                                              HasSubstr("detectors.original_2016.arc_deg"),
                                              Not(HasSubstr("cluster")), Not(HasSubstr("paper_full"))));
  EXPECT_THAT(message({"radius_px=[25, 4]"}), HasSubstr("detectors.cluster.radius_px"));
}

TEST_F(ReadDetectors, WhatIsResolvedReadsBackTheSame) {
  const std::string resolved = resolved_detectors(read({"window.kind=lifetime", "radius_px=[5,9]"}));
  const std::string path = testing::TempDir() + "/resolved_" + std::to_string(::getpid()) + ".yaml";
  std::ofstream(path) << resolved;
  EXPECT_EQ(resolved_detectors(read_detectors(path, {}, built_in_detectors())), resolved);
  std::filesystem::remove(path);
  EXPECT_THAT(resolved, HasSubstr("crossing_px: 3"));
}

}  // namespace
}  // namespace saccade
