#include "core/detector_parts.h"

#include <gtest/gtest.h>

#include "core/detector_views.h"
#include "core/reserved_vector.h"

namespace saccade {
namespace {

TEST(EventSieve, CountsEventsOutsideTheImageAndBackInTime) {
  EventSieve sieve({10, 8});
  EXPECT_TRUE(sieve.accept({5, 9, 7, true, 0}));
  EXPECT_FALSE(sieve.accept({6, 10, 0, true, 0}));
  EXPECT_FALSE(sieve.accept({6, 0, 8, true, 0}));
  EXPECT_TRUE(sieve.accept({5, 0, 0, false, 0})) << "equal time stamps";
  EXPECT_FALSE(sieve.accept({4, 0, 0, false, 0}));
  EXPECT_EQ(sieve.rejected().outside_image, 2);
  EXPECT_EQ(sieve.rejected().back_in_time, 1);
}

TEST(EventSieve, PreviewsABatchWithoutCountingIt) {
  EventSieve sieve({10, 8});
  ASSERT_TRUE(sieve.accept({100, 0, 0, true, 0}));
  const std::vector<Event> batch = {{99, 0, 0, true, 0},
                                    {100, 1, 0, true, 0},
                                    {120, 50, 0, true, 0},
                                    {110, 2, 0, true, 0},
                                    {105, 2, 0, true, 0}};
  const EventSieve::Preview preview = sieve.preview(batch);
  EXPECT_EQ(preview.count, 2);
  EXPECT_EQ(preview.newest_us, 110);
  EXPECT_EQ(sieve.rejected().outside_image + sieve.rejected().back_in_time, 0);
  std::int64_t accepted = 0;
  for (const Event& event : batch) accepted += sieve.accept(event) ? 1 : 0;
  EXPECT_EQ(accepted, preview.count);
}

TEST(ReservedVector, CopiesHaveItsCapacity) {
  ReservedVector<int> original;
  original.reserve(100);
  original.push_back(7);
  const ReservedVector<int> copy = original;
  ReservedVector<int> assigned;
  assigned = original;
  for (const ReservedVector<int>* const vector : {&copy, &std::as_const(assigned)}) {
    EXPECT_EQ(vector->size(), 1U);
    EXPECT_EQ(vector->front(), 7);
    EXPECT_GE(vector->capacity(), 100U);
  }
  original.front() = 8;
  EXPECT_EQ(copy.front(), 7);
}

/// A detector without estimates.
class SilentDetector : public Detector {
 public:
  void process(std::span<const Event>, const CameraMotion*) override {}
  void advance_to(std::int64_t, const CameraMotion*) override {}
  [[nodiscard]] Estimate estimate() override { return {}; }
  [[nodiscard]] double threshold() const override { return 0.0; }
  [[nodiscard]] RejectedEvents rejected() const override { return {}; }
};

class ViewedDetector final : public SilentDetector, public DetectorViews {
 public:
  bool hough_space(std::span<float> response) const override {
    response[0] = 3.0F;
    return true;
  }
  [[nodiscard]] std::unique_ptr<Detector> copy() const override {
    return std::make_unique<ViewedDetector>(*this);
  }
};

TEST(DetectorViews, AreOptional) {
  const SilentDetector silent;
  const ViewedDetector viewed;
  std::vector<float> response(1, 0.0F);
  EXPECT_FALSE(can_be_copied(silent));
  EXPECT_EQ(copy_of(silent), nullptr);
  EXPECT_FALSE(hough_space_of(silent, response));
  EXPECT_EQ(response[0], 0.0F);
  EXPECT_TRUE(can_be_copied(viewed));
  EXPECT_NE(copy_of(viewed), nullptr);
  EXPECT_TRUE(hough_space_of(viewed, response));
  EXPECT_EQ(response[0], 3.0F);
}

}  // namespace
}  // namespace saccade
