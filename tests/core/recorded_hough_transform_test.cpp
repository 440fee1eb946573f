#include <gtest/gtest.h>

#include <deque>

#include "core/flow/plane_fit_flow.h"
#include "core/hough/hough_transform.h"
#include "core/units.h"
#include "tests/core/reference_hough.h"
#include "tests/recording/read_events.h"

namespace saccade {
namespace {

using RecordedHoughTransform = RealRecording;

TEST_F(RecordedHoughTransform, EqualsTheReferenceOnARecordedBall) {
  const std::vector<Event> recorded = read_real("ball_looming_dvs128_aedat2.aedat");
  const ImageSize size{128, 128};
  const std::size_t window = 250;
  for (const bool directed : {false, true}) {
    HoughTransform fast(size, 20, 23, 10 * rad_per_deg);
    ReferenceHough plain(size, 20, 23, window, directed ? std::optional(10 * rad_per_deg) : std::nullopt);
    PlaneFitFlow flow({}, size);
    std::deque<std::pair<Event, std::optional<int>>> entries;  // with its direction
    for (std::size_t i = 0; i < 50'600; ++i) {
      const Event& e = recorded[i];
      flow.add(e);
      if (i < 50'000) continue;
      std::optional<int> direction;
      if (const auto at = flow.at(e))
        direction = HoughTransform::direction_of(at->dt_dx_us_px, at->dt_dy_us_px);
      entries.emplace_back(e, direction);
      plain.push(e.x, e.y, direction ? std::optional(radians_of(*direction)) : std::nullopt);
      if (!directed) fast.vote_ring<1>(e.x, e.y);
      if (directed && direction) fast.vote_arcs<1>(e.x, e.y, *direction);
      if (entries.size() > window) {
        const auto& [old, old_direction] = entries.front();
        if (!directed) fast.vote_ring<-1>(old.x, old.y);
        if (directed && old_direction) fast.vote_arcs<-1>(old.x, old.y, *old_direction);
        entries.pop_front();
      }
      ASSERT_EQ(as_reference(fast.peak()), plain.peak()) << "event " << i;
      if (i % 50 != 0) continue;
      ASSERT_EQ(all_votes(fast), plain.votes()) << "event " << i;
    }
    ASSERT_GT(plain.peak().votes, directed ? 5 : 20);  // something was there to find
  }
}

}  // namespace
}  // namespace saccade
