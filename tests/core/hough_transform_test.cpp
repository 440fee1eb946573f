#include "core/hough/hough_transform.h"

#include <gtest/gtest.h>

#include <cmath>
#include <deque>
#include <numbers>
#include <string>

#include "core/error.h"
#include "core/flow/plane_fit_flow.h"
#include "core/units.h"
#include "tests/core/reference_hough.h"
#include "tests/core/streams.h"

namespace saccade {
namespace {

struct Case {
  ImageSize size;
  int r_min, r_max;
  std::size_t window;
  double arc_deg;  ///< 0: full
};

/// Sizes that are no multiple of anything, radii beyond the image, windows down to 1 and beyond the stream.
/// Radii one short of a power of two reach to the end of the rows kept for them.
const std::vector<Case> cases = {{{23, 17}, 1, 4, 20, 0.0},  {{23, 17}, 2, 9, 40, 10.0},
                                 {{16, 16}, 5, 5, 1, 0.0},   {{11, 29}, 3, 12, 60, 0.0},
                                 {{31, 9}, 4, 20, 33, 10.0}, {{40, 33}, 6, 11, 25, 15.0},
                                 {{8, 8}, 1, 14, 500, 90.0}, {{37, 26}, 10, 15, 50, 3.5},
                                 {{20, 35}, 7, 7, 70, 0.0},  {{18, 18}, 31, 31, 40, 0.0}};

std::string text_of_case(const Case& c, std::string_view kind) {
  return std::string(kind) + " " + std::to_string(c.size.width) + "x" + std::to_string(c.size.height) +
         " radii " + std::to_string(c.r_min) + ".." + std::to_string(c.r_max) + " window " +
         std::to_string(c.window) + (c.arc_deg == 0.0 ? " full" : " directed");
}

TEST(HoughTransform, EqualsTheReferenceAfterEveryEvent) {
  std::size_t compared = 0;
  for (const Case& c : cases) {
    for (const std::string_view kind : {"random", "clustered", "border_hugging"}) {
      SCOPED_TRACE(text_of_case(c, kind));
      const bool directed = c.arc_deg > 0.0;
      const double arc_rad = directed ? c.arc_deg * rad_per_deg : 0.1;
      HoughTransform fast(c.size, c.r_min, c.r_max, arc_rad);
      ReferenceHough plain(c.size, c.r_min, c.r_max, c.window,
                           directed ? std::optional(arc_rad) : std::nullopt);
      const RandomStream random(5, kind);
      std::deque<std::pair<Event, int>> window;  // with its direction
      for (const Event& e : streams::named(kind, c.size, 150, 11)) {
        const auto direction = static_cast<int>(random.bits(0, compared) % HoughTransform::direction_count);
        plain.push(e.x, e.y, radians_of(direction));
        window.emplace_back(e, direction);
        directed ? fast.vote_arcs<1>(e.x, e.y, direction) : fast.vote_ring<1>(e.x, e.y);
        if (window.size() > c.window) {
          const auto& [old, old_direction] = window.front();
          directed ? fast.vote_arcs<-1>(old.x, old.y, old_direction) : fast.vote_ring<-1>(old.x, old.y);
          window.pop_front();
        }
        ASSERT_EQ(all_votes(fast), plain.votes());
        ASSERT_EQ(as_reference(fast.peak()), plain.peak());
        ++compared;
      }
      ASSERT_EQ(plain.votes(), plain.recount());
    }
  }
  std::printf("accumulator and maximum equal the reference after each of %zu events\n", compared);
}

TEST(HoughTransform, ManyEventsAtOnceGiveTheVotesOfSingleEvents) {
  std::size_t compared = 0;
  for (const Case& c : cases) {
    for (const std::string_view kind : {"random", "clustered", "border_hugging"}) {
      SCOPED_TRACE(text_of_case(c, kind));
      const double arc_rad = c.arc_deg > 0.0 ? c.arc_deg * rad_per_deg : 0.1;
      HoughTransform together(c.size, c.r_min, c.r_max, arc_rad);
      HoughTransform one_by_one(c.size, c.r_min, c.r_max, arc_rad);
      const RandomStream random(6, kind);
      std::deque<WindowEvent> inside;
      const auto events = streams::named(kind, c.size, 30'000, 12);
      std::size_t next = 0;
      for (std::uint64_t step = 0; step < 60; ++step) {
        // One event, some, all, or more than are gathered at a time.
        const std::size_t most = step == 50 ? 20'000 : std::size_t{1} << random.bits(0, step) % 8;
        std::vector<WindowEvent> entered, left;
        for (std::size_t i = 0; i < most && next < events.size(); ++i, ++next) {
          const Event& e = events[next];
          const auto direction =
              c.arc_deg > 0.0
                  ? static_cast<std::int16_t>(random.bits(1, next) % HoughTransform::direction_count)
                  : HoughTransform::whole_ring;
          entered.push_back({e.x, e.y, direction});
        }
        EventWindow::Change change;
        change.all_left = step % 9 == 8;
        if (change.all_left) {
          one_by_one.clear();
          inside.clear();
        } else {
          for (std::size_t i = random.bits(2, step) % (inside.size() + 1); i-- > 0; inside.pop_front())
            left.push_back(inside.front());
        }
        inside.insert(inside.end(), entered.begin(), entered.end());
        change.left = left;
        change.entered = entered;
        together.vote(change);
        for (const WindowEvent& e : left)
          c.arc_deg > 0.0 ? one_by_one.vote_arcs<-1>(e.x, e.y, e.direction)
                          : one_by_one.vote_ring<-1>(e.x, e.y);
        for (const WindowEvent& e : entered)
          c.arc_deg > 0.0 ? one_by_one.vote_arcs<1>(e.x, e.y, e.direction)
                          : one_by_one.vote_ring<1>(e.x, e.y);
        ASSERT_EQ(all_votes(together), all_votes(one_by_one)) << step;
        ASSERT_EQ(as_reference(together.peak()), as_reference(one_by_one.peak())) << step;
        ++compared;
      }
      EXPECT_GT(next, 20'000u);
    }
  }
  std::printf("accumulator and maximum equal those of single events after each of %zu changes\n", compared);
}

TEST(HoughTransform, FindsACircleInEveryRowAtTheBorders) {
  // Its events come one by one, so that the maximum moves, rises and ties; then they are taken out again.
  const ImageSize size{21, 35};
  for (int y0 = 0; y0 < size.height; ++y0) {
    for (const int x0 : {0, 1, 2, 3, 18, 20}) {
      HoughTransform fast(size, 3, 6, 10 * rad_per_deg);
      std::vector<Event> circle;
      for (int y = 0; y < size.height; ++y) {
        for (int x = 0; x < size.width; ++x) {
          if (std::abs(std::hypot(x - x0, y - y0) - 5) <= 0.5)
            circle.push_back(streams::event_at(0, x, y, true));
        }
      }
      ReferenceHough plain(size, 3, 6, circle.size(), std::nullopt);
      for (const Event& e : circle) {
        fast.vote_ring<1>(e.x, e.y);
        plain.push(e.x, e.y, std::nullopt);
        ASSERT_EQ(as_reference(fast.peak()), plain.peak()) << "(" << x0 << ", " << y0 << ")";
      }
      ASSERT_EQ(fast.votes(x0, y0, 5), static_cast<int>(circle.size()));
      for (std::size_t i = circle.size(); i-- > 0;) {
        ASSERT_GE(fast.peak().response, static_cast<double>(i + 1) / fast.divisor(5)) << x0 << ", " << y0;
        fast.vote_ring<-1>(circle[i].x, circle[i].y);
      }
      ASSERT_EQ(fast.peak().votes, 0);
    }
  }
}

TEST(HoughTransform, GivesTheSamePeakForAnyIntervalBetweenCalls) {
  for (const std::string_view kind : {"random", "clustered", "border_hugging"}) {
    HoughTransform often({40, 33}, 6, 11, 15 * rad_per_deg);
    HoughTransform rarely({40, 33}, 6, 11, 15 * rad_per_deg);
    const std::vector<Event> events = streams::named(kind, {40, 33}, 6000, 7);
    const auto direction = [](const Event& e) { return (e.x * 31 + e.y) % HoughTransform::direction_count; };
    for (std::size_t i = 0; i < events.size(); ++i) {
      for (HoughTransform* transform : {&often, &rarely}) {
        transform->vote_arcs<1>(events[i].x, events[i].y, direction(events[i]));
        if (i < 90) continue;
        const Event& old = events[i - 90];
        transform->vote_arcs<-1>(old.x, old.y, direction(old));
      }
      const HoughTransform::Peak peak = often.peak();
      if (i % 37 != 0) continue;
      ASSERT_EQ(as_reference(peak), as_reference(rarely.peak())) << kind << ", event " << i;
    }
  }
}

TEST(HoughTransform, FindsACircleInALongImageWithManyRadii) {
  // As many cells for each row of blocks as 2048 x 2048 pixels with radii from 10 to 130, in a hundredth of the memory.
  HoughTransform transform({65535, 8}, 1, 16, 10 * rad_per_deg);
  transform.vote_ring<1>(65'000, 4);
  transform.vote_ring<1>(65'000 + 2 * 7, 4);
  const HoughTransform::Peak peak = transform.peak();
  EXPECT_EQ(peak.r, 1);
  EXPECT_EQ(peak.votes, 1);
  EXPECT_EQ(peak.x, 64'999);
  EXPECT_EQ(transform.votes(65'007, 4, 7), 2);
  transform.vote_ring<-1>(65'000, 4);
  transform.vote_ring<-1>(65'000 + 2 * 7, 4);
  EXPECT_EQ(transform.peak().votes, 0);
}

TEST(HoughTransform, RejectsAnImageAndRadiiThatNeedTooManyCells) {
  try {
    const HoughTransform transform({65535, 65535}, 1, 255, 10 * rad_per_deg);
    FAIL() << "65535 x 65535 pixels with 255 radii were accepted";
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()),
              "radius_px: found [1, 255], expected fewer radii: for an image of 65535 x 65535 pixels the "
              "Hough space "
              "is too large");
  }
}

TEST(HoughTransform, DividesByThePerimeterOrNotAtAllIfConfigured) {
  HoughTransform perimeter({64, 64}, 5, 12, 1.0, HoughTransform::Normalisation::perimeter);
  HoughTransform plain({64, 64}, 5, 12, 1.0, HoughTransform::Normalisation::none);
  for (HoughTransform* transform : {&perimeter, &plain}) {
    // Nine events on a circle of 5 px and ten on one of 12 px around the same pixel.
    for (int k = 0; k < 9; ++k) {
      const double a = 0.7 * k;
      transform->vote_ring<1>(static_cast<int>(std::lround(30 + 5 * std::cos(a))),
                              static_cast<int>(std::lround(30 + 5 * std::sin(a))));
    }
    for (int k = 0; k < 10; ++k) {
      const double a = 0.62 * k;
      transform->vote_ring<1>(static_cast<int>(std::lround(30 + 12 * std::cos(a))),
                              static_cast<int>(std::lround(30 + 12 * std::sin(a))));
    }
  }
  EXPECT_EQ(perimeter.peak().r, 5) << "9 of 31 px are more than 10 of 75";
  EXPECT_EQ(perimeter.peak().response, perimeter.peak().votes / 31.0);
  EXPECT_EQ(plain.peak().r, 12) << "10 votes are more than 9";
  EXPECT_EQ(plain.peak().response, plain.peak().votes);
}

TEST(HoughTransform, NormalisesByTheCountedPixelsOfTheHalfPixelRing) {
  const HoughTransform transform({16, 16}, 1, 40, 10 * rad_per_deg);
  const ReferenceHough plain({16, 16}, 1, 40, 1, std::nullopt);
  for (int r = 1; r <= 40; ++r) EXPECT_EQ(transform.divisor(r), plain.ring_pixels(r)) << r;
  // By hand: the eight neighbours, and the square ring of 12 pixels without corners.
  EXPECT_EQ(transform.divisor(1), 8);
  EXPECT_EQ(transform.divisor(2), 12);
}

TEST(HoughTransform, ACompleteRingHasTheResponseOneAtItsCentre) {
  for (const int r : {3, 10, 17}) {
    HoughTransform transform({64, 48}, 2, 20, 10 * rad_per_deg);
    for (int y = 0; y < 48; ++y) {
      for (int x = 0; x < 64; ++x) {
        if (std::abs(std::hypot(x - 30, y - 22) - r) <= 0.5) transform.vote_ring<1>(x, y);
      }
    }
    EXPECT_EQ(as_reference(transform.peak()), (ReferenceHough::Peak{30, 22, r, transform.divisor(r)}));
    EXPECT_DOUBLE_EQ(transform.peak().response, 1.0);
  }
}

TEST(HoughTransform, BreaksTiesBySmallerRadiusThenRowThenColumn) {
  // One full vote: the pixels of every ring hold one vote, so the ring of fewest pixels wins.
  HoughTransform transform({40, 30}, 4, 8, 10 * rad_per_deg);
  transform.vote_ring<1>(20, 15);
  ReferenceHough plain({40, 30}, 4, 8, 1, std::nullopt);
  plain.push(20, 15, std::nullopt);
  EXPECT_EQ(as_reference(transform.peak()), plain.peak());
  EXPECT_EQ(as_reference(transform.peak()), (ReferenceHough::Peak{18, 10, 5, 1}));  // 28 pixels; its top row
  // Equal responses from different counts: a ring of 3 has 16 pixels, one of 4 has 32. Events more than 7 px
  // apart share centres at radius 4 only: 2 / 32 meets 1 / 16 and the smaller radius wins, 3 / 32 beats it.
  HoughTransform two({40, 30}, 3, 4, 10 * rad_per_deg);
  two.vote_ring<1>(12, 15);
  two.vote_ring<1>(18, 11);
  EXPECT_EQ(two.votes(16, 15, 4), 2);
  EXPECT_EQ(as_reference(two.peak()), (ReferenceHough::Peak{17, 8, 3, 1}));
  two.vote_ring<1>(18, 19);
  EXPECT_EQ(as_reference(two.peak()), (ReferenceHough::Peak{16, 15, 4, 3}));
  two.vote_ring<-1>(18, 19);
  EXPECT_EQ(as_reference(two.peak()), (ReferenceHough::Peak{17, 8, 3, 1}));
}

TEST(HoughTransform, IsEmptyAfterEveryVoteIsRemovedOrCleared) {
  const ImageSize size{50, 40};
  HoughTransform transform(size, 5, 12, 10 * rad_per_deg);
  const HoughTransform::Peak empty{0, 0, 5, 0, 0.0};
  const auto expect_empty = [&] {
    for (const int votes : all_votes(transform)) ASSERT_EQ(votes, 0);
    EXPECT_EQ(as_reference(transform.peak()), as_reference(empty));
    EXPECT_EQ(transform.peak().response, 0.0);
  };
  expect_empty();
  const std::vector<Event> events = streams::random(size, 400, 3);
  for (const Event& e : events) transform.vote_arcs<1>(e.x, e.y, e.x % HoughTransform::direction_count);
  EXPECT_GT(transform.peak().votes, 0);
  for (const Event& e : events) transform.vote_arcs<-1>(e.x, e.y, e.x % HoughTransform::direction_count);
  expect_empty();
  for (const Event& e : events) transform.vote_ring<1>(e.x, e.y);
  EXPECT_GT(transform.peak().votes, 0);
  transform.clear();
  expect_empty();
  transform.vote_ring<1>(20, 20);
  EXPECT_EQ(transform.peak().votes, 1);
}

TEST(HoughTransform, CountsMoreThan255Votes) {
  HoughTransform transform({32, 32}, 3, 6, 10 * rad_per_deg);
  for (int i = 0; i < 60'000; ++i) transform.vote_ring<1>(16, 16);
  EXPECT_EQ(transform.peak().votes, 60'000);
  EXPECT_EQ(transform.votes(19, 16, 3), 60'000);
}

TEST(HoughTransform, GivesTheZeroVectorTheDirectionZero) {
  EXPECT_EQ(HoughTransform::direction_of(0.0, 0.0), 0);
  EXPECT_EQ(HoughTransform::direction_of(-0.0, 0.0), 0);
}

TEST(HoughTransform, QuantisesDirectionsToHalfADegreeModuloAHalfTurn) {
  for (int i = -720; i < 720; ++i) {
    const double angle = i * 0.25 * rad_per_deg + 0.05 * rad_per_deg;
    const int direction = HoughTransform::direction_of(3.0 * std::cos(angle), 3.0 * std::sin(angle));
    ASSERT_GE(direction, 0);
    ASSERT_LT(direction, HoughTransform::direction_count);
    EXPECT_LE(std::abs(std::remainder(radians_of(direction) - angle, std::numbers::pi)),
              0.25 * rad_per_deg + 1e-12);
    EXPECT_EQ(direction, HoughTransform::direction_of(-std::cos(angle), -std::sin(angle)));
  }
  const RandomStream random(3, "directions");
  for (std::uint64_t i = 0; i < 100'000; ++i) {
    const double x = random.uniform(-1.0, 1.0, 0, i) * std::exp(random.uniform(-8.0, 8.0, 1, i));
    const double y = random.uniform(-1.0, 1.0, 2, i);
    const double steps = std::atan2(y, x) / std::numbers::pi * HoughTransform::direction_count;
    const int nearest = static_cast<int>(std::lround(steps) + 720) % HoughTransform::direction_count;
    ASSERT_EQ(HoughTransform::direction_of(x, y), nearest) << "(" << x << ", " << y << ")";
  }
  EXPECT_EQ(HoughTransform::direction_of(1.0, 0.0), 0);
  EXPECT_EQ(HoughTransform::direction_of(-1.0, -0.0), 0);
  EXPECT_EQ(HoughTransform::direction_of(0.0, 5.0), 180);
}

}  // namespace
}  // namespace saccade
