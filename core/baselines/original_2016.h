#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/detector_parts.h"
#include "core/detector_views.h"
#include "core/flow/plane_fit_flow.h"

namespace saccade {

/// Which cell of a radius counts as its maximum.
enum class MaximumSearch { remembered, exact };
constexpr auto words_of(MaximumSearch) {
  return std::to_array<Word<MaximumSearch>>(
      {{MaximumSearch::remembered, "remembered"}, {MaximumSearch::exact, "exact"}});
}

/// What the circle detector of the event-driven project did when the paper came out (vCircle, February and
/// March 2016), where that differs from what the paper says.
struct Original2016Config {
  std::array<double, 2> radius_px = {10, 35};  ///< smallest and largest radius, whole numbers
  std::int64_t window_events = 1000;
  double arc_deg = 15.0;         ///< half-width of an arc
  std::int64_t min_inliers = 5;  ///< of the nine events of a patch that must lie on its plane
  MaximumSearch maximum = MaximumSearch::remembered;  ///< remembered, as then, or exact
  double threshold = 0.5;  ///< votes per pixel of the look-up ring taken for the ball
};

/// Keys: radius_px, window.events, arc_deg, flow.min_inliers, maximum, threshold.
void describe(FieldVisitor& v, Original2016Config& config);
/// The events that the response is made of: "1000 events".
[[nodiscard]] std::string window_text(const Original2016Config& config);

/// The directed Hough transform of the authors' code of 2016, event by event:
///  - Flow comes from nine shifted patches of 3 x 3 pixels of one polarity around the event. Of the completely filled
///    patches the newest is used. An inlier differs from the time that the slope predicts by at most half the slope.
///  - Only events with flow enter the window. A new event first removes an older one at the same pixel.
///  - A vote falls on the pixels of a look-up ring (up to 0.4 px outside the radius). The response is votes divided by
///    the number of these pixels.
///  - Each radius stores its best cell. Another cell replaces it only when a vote has just raised that cell above it;
///    removing votes does not start a new search (unless `maximum` is exact).
class Original2016 final : public Detector, public DetectorViews {
 public:
  /// Throws InputError for a configuration out of range.
  Original2016(const Original2016Config& config, ImageSize size);

  void process(std::span<const Event> events, const CameraMotion* motion) override;
  void advance_to(std::int64_t, const CameraMotion*) override {}
  [[nodiscard]] Estimate estimate() override;
  [[nodiscard]] double threshold() const override { return config_.threshold; }
  [[nodiscard]] RejectedEvents rejected() const override { return sieve_.rejected(); }
  [[nodiscard]] bool hough_space(std::span<float> response) const override;
  [[nodiscard]] std::unique_ptr<Detector> copy() const override {
    return std::make_unique<Original2016>(*this);
  }

 private:
  static constexpr int direction_count = 180;  // steps of a degree, modulo a half turn
  struct Offset {
    int dx, dy;
    std::ptrdiff_t at;  // from the event's pixel to the cell
  };
  struct Radius {
    int r_px = 0;
    double ring_pixels = 0;
    std::vector<std::uint16_t> votes;
    std::size_t best = 0;  // index of the remembered cell
  };
  /// The centres that an event of a direction votes for, relative to it: one radius after the other.
  struct Arcs {
    std::vector<Offset> offsets;
    std::vector<std::size_t> ends;  // of each radius
  };
  static constexpr int none = -1;
  /// The window contains at most one event per pixel: it is a list of pixels from the oldest to the newest event.
  struct Member {
    int older = none, newer = none;
    int direction = none;  // none: not in the window
  };

  [[nodiscard]] int pixel(int x, int y) const { return y * size_.width + x; }
  void tabulate(int r_px);
  [[nodiscard]] std::optional<NormalFlow> flow_at(const Event& event) const;
  void enter(int pixel, int direction);
  void leave(int pixel);
  void vote(int pixel, int direction);
  void take_back(int pixel, int direction);
  template <class Count>
  void for_votes(int pixel, int direction, const Count& count);

  Original2016Config config_;
  bool exact_maximum_;
  ImageSize size_;
  EventSieve sieve_;
  std::array<std::vector<std::int64_t>, 2> surface_;  // per polarity, newest stamp of each pixel
  std::vector<Radius> radii_;
  std::array<Arcs, direction_count> arcs_;
  std::vector<Member> window_;  // by pixel
  int oldest_ = none, newest_ = none;
  std::int64_t count_ = 0;
};

}  // namespace saccade
