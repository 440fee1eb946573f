#include "core/flow/plane_fit_flow.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/units.h"
#include "tests/core/reference_flow.h"
#include "tests/core/streams.h"

namespace saccade {
namespace {

double median(std::vector<double> values) {
  EXPECT_FALSE(values.empty());
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Adds every event and returns the flow at the last one.
std::optional<NormalFlow> flow_after(const std::vector<Event>& events,
                                     const PlaneFitFlowConfig& config = {}) {
  PlaneFitFlow flow(config, {128, 128});
  for (const Event& e : events) flow.add(e);
  return flow.at(events.back());
}

/// A 5x5 patch swept to the right at 1 ms per pixel, its centre last.
std::vector<Event> swept_patch(int x0, int y0, bool on = true) {
  std::vector<Event> events;
  for (int dx = -2; dx <= 0; ++dx) {
    for (int dy = -2; dy <= 2; ++dy) {
      if (dx != 0 || dy != 0) events.push_back(streams::event_at(10'000 + 1000 * dx, x0 + dx, y0 + dy, on));
    }
  }
  events.push_back(streams::event_at(10'000, x0, y0, on));
  return events;
}

TEST(PlaneFitFlow, EqualsADenseLeastSquaresFit) {
  std::size_t with_flow = 0;
  std::size_t compared = 0;
  for (const std::int64_t half : {1, 2, 3, 5}) {
    PlaneFitFlowConfig config;
    config.half_width_px = half;
    config.max_age_us = 1'000;
    const ImageSize size{24, 18};
    for (const std::string_view kind : {"random", "clustered", "border_hugging"}) {
      PlaneFitFlow fast(config, size);
      ReferenceFlow plain(config);
      for (const Event& e : streams::named(kind, size, 2000, 21)) {
        fast.add(e);
        plain.add(e);
        const ReferenceFlow::Answer expected = plain.at(e);
        if (!expected.clear_cut) continue;
        const auto flow = fast.at(e);
        ASSERT_EQ(flow.has_value(), expected.flow.has_value()) << kind << " at " << e.t_us << " us";
        ++compared;
        if (!flow) continue;
        ++with_flow;
        const double tolerance = 1e-9 * (1.0 + std::hypot(flow->dt_dx_us_px, flow->dt_dy_us_px));
        ASSERT_NEAR(flow->dt_dx_us_px, expected.flow->dt_dx_us_px, tolerance);
        ASSERT_NEAR(flow->dt_dy_us_px, expected.flow->dt_dy_us_px, tolerance);
      }
    }
  }
  std::printf("equal at %zu events, %zu of them with flow\n", compared, with_flow);
  EXPECT_GT(compared, 20'000U);
  EXPECT_GT(with_flow, 1'500U);
}

TEST(PlaneFitFlow, IsTheSameAtTheEarliestAndTheLatestTimeStamps) {
  const std::vector<Event> events = streams::named("clustered", {24, 18}, 2000, 21);
  for (const std::int64_t shift_us : streams::shifts_to_the_ends_of_time(events.back().t_us)) {
    PlaneFitFlow original({}, {24, 18});
    PlaneFitFlow shifted({}, {24, 18});
    int with_flow = 0;
    for (const Event& e : events) {
      Event moved = e;
      moved.t_us += shift_us;
      original.add(e);
      shifted.add(moved);
      const auto expected = original.at(e);
      const auto flow = shifted.at(moved);
      ASSERT_EQ(flow.has_value(), expected.has_value()) << "at " << e.t_us << " us, shift " << shift_us;
      if (!flow) continue;
      ++with_flow;
      ASSERT_EQ(flow->dt_dx_us_px, expected->dt_dx_us_px);
      ASSERT_EQ(flow->dt_dy_us_px, expected->dt_dy_us_px);
    }
    EXPECT_GT(with_flow, 100);
  }
}

TEST(PlaneFitFlow, MeasuresDirectionAndSpeedOfStraightEdges) {
  // Stamps are whole microseconds: at 5000 px/s 5 pixels are 1000 us, so rounding is below 0.1 %.
  double worst_direction_deg = 0.0;
  double worst_speed = 0.0;
  for (int angle_deg = 0; angle_deg < 360; angle_deg += 7) {
    for (const double speed_px_s : {30.0, 300.0, 5000.0}) {
      const double angle = angle_deg * rad_per_deg;
      PlaneFitFlow flow({}, {64, 64});
      std::vector<double> direction_error_deg;
      std::vector<double> speed_error;
      for (const Event& e : streams::moving_edge({64, 64}, angle, speed_px_s, true)) {
        flow.add(e);
        const auto at = flow.at(e);
        if (!at) continue;
        const double measured = std::atan2(at->dt_dy_us_px, at->dt_dx_us_px);
        direction_error_deg.push_back(std::abs(std::remainder(measured - angle, 2 * std::numbers::pi)) /
                                      rad_per_deg);
        const double speed = 1e6 / std::hypot(at->dt_dx_us_px, at->dt_dy_us_px);
        speed_error.push_back(std::abs(speed / speed_px_s - 1.0));
      }
      EXPECT_GT(direction_error_deg.size(), 3000U) << angle_deg << " deg, " << speed_px_s << " px/s";
      worst_direction_deg = std::max(worst_direction_deg, median(direction_error_deg));
      worst_speed = std::max(worst_speed, median(speed_error));
    }
  }
  std::printf("worst median: direction %.4f deg, speed %.5f relative\n", worst_direction_deg, worst_speed);
  EXPECT_LT(worst_direction_deg, 0.2);
  EXPECT_LT(worst_speed, 0.005);
}

TEST(PlaneFitFlow, PointsAtTheCentreOfAMovingCircle) {
  for (const double r : {10.0, 20.0, 35.0}) {
    std::vector<double> error_deg;
    for (int heading_deg = 0; heading_deg < 360; heading_deg += 30) {
      const double heading = heading_deg * rad_per_deg;
      const streams::MovingDisc disc{64 - 20 * std::cos(heading), 64 - 20 * std::sin(heading),
                                     400 * std::cos(heading), 400 * std::sin(heading), r};
      PlaneFitFlow flow({}, {128, 128});
      for (const Event& e : disc.events({128, 128}, 0.1)) {
        flow.add(e);
        const auto at = flow.at(e);
        if (!at || e.t_us < 10'000) continue;
        const double radial = std::atan2(e.y - disc.y_at(e.t_us), e.x - disc.x_at(e.t_us));
        const double measured = std::atan2(at->dt_dy_us_px, at->dt_dx_us_px);
        error_deg.push_back(std::abs(std::remainder(measured - radial, std::numbers::pi)) / rad_per_deg);
      }
    }
    std::sort(error_deg.begin(), error_deg.end());
    const double within_arc =
        static_cast<double>(std::lower_bound(error_deg.begin(), error_deg.end(), 10.0) - error_deg.begin()) /
        static_cast<double>(error_deg.size());
    std::printf("r %.0f px: median %.2f deg, %.1f %% within the arc of 10 deg (%zu flows)\n", r,
                median(error_deg), 100 * within_arc, error_deg.size());
    // The neighbours lie on the side the edge comes from, up to a pixel behind the event: below 1 / r rad.
    EXPECT_LT(median(error_deg), 0.7 / r / rad_per_deg) << r;
    EXPECT_GT(within_arc, 0.9) << r;
  }
}

TEST(PlaneFitFlow, FitsASweptPatchExactly) {
  const auto flow = flow_after(swept_patch(60, 60));
  ASSERT_TRUE(flow);
  EXPECT_DOUBLE_EQ(flow->dt_dx_us_px, 1000.0);
  EXPECT_DOUBLE_EQ(flow->dt_dy_us_px, 0.0);
}

TEST(PlaneFitFlow, IsAbsentOnALevelPlane) {
  std::vector<Event> events = swept_patch(60, 60);
  for (Event& e : events) e.t_us = 500;
  EXPECT_FALSE(flow_after(events));
}

TEST(PlaneFitFlow, IsAbsentOnOneLineOfPixels) {
  std::vector<Event> events;
  for (int i = -5; i <= 0; ++i) events.push_back(streams::event_at(1000 * i, 60 + i, 60 + i, true));
  PlaneFitFlowConfig config;
  config.half_width_px = 5;
  EXPECT_FALSE(flow_after(events, config));
  events.insert(events.begin(), streams::event_at(-9000, 60, 55, true));  // one beside it makes a plane
  EXPECT_TRUE(flow_after(events, config));
}

TEST(PlaneFitFlow, NeedsTheConfiguredNumberOfInliers) {
  const std::vector<Event> events = swept_patch(60, 60);  // 15 events on one plane
  PlaneFitFlowConfig config;
  config.min_inliers = static_cast<std::int64_t>(events.size());
  EXPECT_TRUE(flow_after(events, config));
  EXPECT_FALSE(flow_after({events.begin() + 1, events.end()}, config));
  EXPECT_FALSE(flow_after({events.back()}));
}

TEST(PlaneFitFlow, ExcludesNeighboursOffThePlane) {
  std::vector<Event> events = swept_patch(60, 60);
  events.insert(events.begin(), streams::event_at(9'000, 62, 58, true));  // 3 px off this plane
  const auto flow = flow_after(events);
  ASSERT_TRUE(flow);
  EXPECT_NEAR(flow->dt_dx_us_px, 1000.0, 1e-9);
  EXPECT_NEAR(flow->dt_dy_us_px, 0.0, 1e-9);
}

TEST(PlaneFitFlow, IsNotAffectedByAnEarlierEdge) {
  // Another edge left its stamps ahead of this one, too young for the maximum age, sloping another way: ten of
  // 25 neighbours, which alone would turn the first fit far round.
  for (const std::int64_t ago_us : {8'000, 20'000, 90'000}) {
    std::vector<Event> events = swept_patch(60, 60);
    for (int dx = 1; dx <= 2; ++dx) {
      for (int dy = -2; dy <= 2; ++dy) {
        events.insert(events.begin(), streams::event_at(10'000 - ago_us + 700 * dy, 60 + dx, 60 + dy, true));
      }
    }
    const auto flow = flow_after(events);
    ASSERT_TRUE(flow) << ago_us;
    EXPECT_NEAR(flow->dt_dx_us_px, 1000.0, 1e-9) << ago_us;
    EXPECT_NEAR(flow->dt_dy_us_px, 0.0, 1e-9) << ago_us;
  }
}

TEST(PlaneFitFlow, UsesOnePolarityOnly) {
  std::vector<Event> events = swept_patch(60, 60, true);
  const Event last = events.back();
  events.pop_back();
  events.push_back({last.t_us, last.x, last.y, !last.on, 0});
  EXPECT_FALSE(flow_after(events));
  // The other polarity's surface of the same pixels does not disturb: same flow as without it.
  std::vector<Event> both = swept_patch(60, 60, true);
  for (Event e : swept_patch(60, 60, true)) {
    e.on = false;
    e.t_us = 10'000 - 777 * (e.y % 5);
    both.insert(both.begin(), e);
  }
  const auto flow = flow_after(both);
  ASSERT_TRUE(flow);
  EXPECT_DOUBLE_EQ(flow->dt_dx_us_px, 1000.0);
}

TEST(PlaneFitFlow, IgnoresNeighboursOlderThanTheMaximumAge) {
  PlaneFitFlowConfig config;
  config.max_age_us = 2'000;  // the first column of the patch is exactly that old
  EXPECT_TRUE(flow_after(swept_patch(60, 60), config));
  config.max_age_us = 1'999;
  config.min_inliers = 11;  // the two younger columns are 10
  EXPECT_FALSE(flow_after(swept_patch(60, 60), config));
  config.min_inliers = 10;
  EXPECT_TRUE(flow_after(swept_patch(60, 60), config));
}

TEST(PlaneFitFlow, WorksAtTheImageBorder) {
  // Half of the neighbourhood lies outside: the fit has fewer points and the same answer.
  for (const int y : {0, 127}) {
    std::vector<Event> events;
    for (const Event& e : swept_patch(2, 60)) {
      if (y == 0 ? e.y >= 60 : e.y <= 60)
        events.push_back({e.t_us, e.x, static_cast<std::uint16_t>(e.y + y - 60), e.on, 0});
    }
    const auto flow = flow_after(events);
    ASSERT_TRUE(flow) << y;
    EXPECT_NEAR(flow->dt_dx_us_px, 1000.0, 1e-9);
  }
  // Rows do not run into each other: an edge along the right border is not seen at the left border.
  PlaneFitFlow flow({}, {128, 128});
  for (int y = 40; y < 60; ++y) {
    for (int x = 124; x < 128; ++x) flow.add(streams::event_at(1000 * x, x, y, true));
  }
  const Event alone = streams::event_at(128'000, 0, 50, true);
  flow.add(alone);
  EXPECT_FALSE(flow.at(alone));
}

TEST(PlaneFitFlow, WorksAtAnyAbsoluteTime) {
  for (const std::int64_t t0 : {std::int64_t{-4'000'000'000'000}, std::int64_t{1'000'000'000'000'000}}) {
    std::vector<Event> events = swept_patch(60, 60);
    for (Event& e : events) e.t_us += t0;
    const auto flow = flow_after(events);
    ASSERT_TRUE(flow);
    EXPECT_DOUBLE_EQ(flow->dt_dx_us_px, 1000.0);
  }
}

}  // namespace
}  // namespace saccade
