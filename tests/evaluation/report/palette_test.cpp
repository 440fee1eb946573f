#include "evaluation/report/palette.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

namespace saccade {
namespace {

/// Linear RGB as a person without red or without green cones sees it (Viénot, Brettel and Mollon 1999).
std::array<double, 3> seen_by_dichromat(Colour c, bool protan) {
  const auto linear = [](std::uint8_t v) { return std::pow(v / 255.0, 2.2); };
  const double r = linear(c.red);
  const double g = linear(c.green);
  const double b = linear(c.blue);
  const double l = 17.8824 * r + 43.5161 * g + 4.11935 * b;
  const double m = 3.45565 * r + 27.1554 * g + 3.86714 * b;
  const double s = 0.0299566 * r + 0.184309 * g + 1.46709 * b;
  const double l2 = protan ? 2.02344 * m - 2.52581 * s : l;
  const double m2 = protan ? m : 0.494207 * l + 1.24827 * s;
  return {l2, m2, s};
}

double apart(Colour a, Colour b, bool protan) {
  const auto p = seen_by_dichromat(a, protan);
  const auto q = seen_by_dichromat(b, protan);
  double largest = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    largest = std::max(largest, std::abs(p[i] - q[i]) / (0.05 * std::max(p[i], q[i]) + 0.01));
  }
  return largest;
}

TEST(Palette, TheDetectorsOfThisProjectAndEventsTruthAndGazeHaveDifferentColours) {
  std::set<std::string> colours;
  for (const Colour c : {on_colour, off_colour, truth_colour, gaze_colour, gaze_target_colour})
    colours.insert(hex(c));
  for (const char* const name :
       {"best", "paper_full", "paper_directed", "frame_30hz", "lifetime", "single_radius", "original_2016",
        "cluster", "multi_kernel", "eros", "scarf", "particle_filter", "blob_filter"})
    colours.insert(hex(detector_colour(name)));
  EXPECT_EQ(colours.size(), 5U + 13U);
}

TEST(Palette, NamesOfOnesOwnHaveColoursUnlikeThoseOfThisProjectsMainDetectorsAndOfTheTruth) {
  const auto distance = [](Colour a, Colour b) {
    return std::hypot(a.red - b.red, a.green - b.green, a.blue - b.blue);
  };
  std::set<std::string> colours;
  for (int i = 0; i < 500; ++i) {
    const Colour mine = detector_colour("mine_" + std::to_string(i));
    colours.insert(hex(mine));
    for (const char* const other : {"best", "paper_full", "paper_directed", "frame_30hz"})
      EXPECT_GT(distance(mine, detector_colour(other)), 40.0) << i << " " << hex(mine) << " " << other;
    EXPECT_GT(distance(mine, detector_colour("best")), 70.0) << i << " " << hex(mine);
    EXPECT_GT(distance(mine, truth_colour), 60.0) << i << " " << hex(mine);
  }
  EXPECT_GT(colours.size(), 490U) << "hardly two are equal";
}

TEST(Palette, TheColourOfANameIsTheSameOnEveryMachine) {
  EXPECT_EQ(hex(detector_colour("RingMeanShift")), "#c1a6d3");
  EXPECT_EQ(hex(detector_colour("my_ring")), "#713bab");
}

TEST(Palette, WhatIsDrawnTogetherDiffersForColourBlindReaders) {
  const std::vector<Colour> together = {truth_colour, detector_colour("best"), detector_colour("paper_full"),
                                        detector_colour("paper_directed")};
  for (const bool protan : {false, true}) {
    EXPECT_GT(apart(on_colour, off_colour, protan), 2.0);
    for (std::size_t i = 0; i < together.size(); ++i) {
      for (std::size_t k = 0; k < i; ++k) {
        EXPECT_GT(apart(together[i], together[k], protan), 2.0) << hex(together[i]) << hex(together[k]);
      }
    }
  }
}

TEST(Palette, HexIsRedGreenBlue) { EXPECT_EQ(hex({1, 0xab, 0xff}), "#01abff"); }

}  // namespace
}  // namespace saccade
