#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/circle_track.h"
#include "core/detector_parts.h"
#include "core/detector_views.h"
#include "core/edge_map.h"
#include "core/hough_transform.h"
#include "core/plane_fit_flow.h"
#include "core/silhouette.h"

namespace saccade {

/// Configuration of the recommended detector, `best`.
struct BallTrackerConfig {
  std::array<double, 2> radius_px = {10, 35};  ///< smallest and largest radius, whole numbers
  double threshold = 0.25;                     ///< score from which on a circle is taken for the ball
  double arc_deg = 12.0;                       ///< half-width of an arc of directed votes
  PlaneFitFlowConfig flow;
  /// An event that follows one of its pixel and polarity sooner than this is of the same edge.
  std::int64_t burst_us = 500;
  std::int64_t edges_per_region = 24;  ///< kept of each 8 x 8 pixels
  double crossing_px = 2.5;            ///< an edge is kept while it moves on so far
  std::int64_t longest_us = 300'000;   ///< and no longer than this
  double hold_s = 3.0;                 ///< a circle that makes no events is held for so long
};

/// Keys: radius_px, threshold, arc_deg, flow, burst_us, edges_per_region, crossing_px, longest_us, hold_s.
void describe(FieldVisitor& v, BallTrackerConfig& config);

/// The recommended detector: tracks up to four circles on the moving edges of the image and returns the one with the
/// highest score.
///
/// 1. Events with a normal flow (plane fit), the first of each burst of a pixel, become edges, kept by region and for as long as they take to move
///    on by crossing_px (EdgeMap): thin outlines at any speed, whatever else moves.
/// 2. Every few ms the edges, moved on to now, vote in the directed Hough transform. The strongest circles are
///    candidates, each fitted by least squares and worth what its outline shows: the share of its
///    directions that are seen, how much of what lies on it moves along its normal, how empty it is.
/// 3. Up to four circles are followed at once, edge by edge (CircleTrack). Their scores follow what their
///    outlines show: fast where nothing else moves, hardly where clutter around them is as dense as they are;
///    then they coast, carried along by the camera's own rotation where joints tell it. Silence is no
///    evidence against a circle at rest: it is held.
/// 4. Where the camera's rotation is known, what moves by itself is worth more than what stands in the room.
/// 5. A ball that the gaze follows makes hardly any events while all around it does: the hole it leaves
///    (Silhouette) tells where it is, and counts as much as an outline.
///
/// Score: 0 to 1. Everything happens at instants of 1 ms of the stream's own time, so that the estimate does
/// not depend on how events come in batches.
/// After: paper, section V (future work); regions after Glover, Dinale, Bartolozzi et al. (event surfaces
/// SCARF and EROS of the same group).
class BallTracker final : public Detector, public DetectorViews {
 public:
  /// Throws InputError for a configuration out of range.
  BallTracker(const BallTrackerConfig& config, const Camera& camera);

  void process(std::span<const Event> events, const CameraMotion* motion) override;
  void advance_to(std::int64_t now_us, const CameraMotion* motion) override;
  [[nodiscard]] Estimate estimate() override;
  [[nodiscard]] double threshold() const override { return config_.threshold; }
  [[nodiscard]] RejectedEvents rejected() const override { return sieve_.rejected(); }
  bool hough_space(std::span<float> response) const override;
  [[nodiscard]] std::unique_ptr<Detector> copy() const override {
    return std::make_unique<BallTracker>(*this);
  }

 private:
  /// What the edges show of a circle's outline.
  struct Outline {
    double quality = 0.0;   ///< 0 to 1
    double activity = 0.0;  ///< edges on it per px of its length
    double calm = 1.0;      ///< 0 to 1: how little moves just outside it
    double clarity = 0.0;   ///< 0 to 1: how much denser than around it edges are on it
  };
  struct Candidate {
    Circle circle;
    double quality = 0.0;
    double clarity = 0.0;
  };
  struct Followed {
    bool alive = false;
    CircleTrack track;
    Silhouette silhouette;
    double score = 0.0;
    double worth = 0.0;  ///< score, less what stands in the room
    double clarity = 1.0;
    double hole = 0.0;  ///< 0 to 1: how surely its silhouette is one that the gaze follows
    Eigen::Vector2d anchor_px = Eigen::Vector2d::Zero();  ///< where it would be if it stood in the room
    [[nodiscard]] double moved_px() const { return (track.centre() - anchor_px).norm(); }
  };
  struct Vote {
    std::uint16_t x, y;
    std::int16_t direction;
    bool explained;
  };

  void know(const CameraMotion* motion);
  [[nodiscard]] bool continues_burst(const Event& event);
  [[nodiscard]] Eigen::Vector2d camera_flow_px_s(const Eigen::Vector2d& at_px) const;
  [[nodiscard]] Eigen::Vector2d camera_flow_px_s(const Edge& edge) const;
  [[nodiscard]] Eigen::Vector2d now_at(const Edge& edge, std::int64_t now_us) const;
  template <class Function>
  void for_each_on(const Circle& circle, double off_px, std::int64_t now_us, Function f) const;
  [[nodiscard]] Outline outline(const Circle& circle, std::int64_t now_us) const;
  [[nodiscard]] Circle fit(Circle circle, std::int64_t now_us) const;

  void run_until(std::int64_t t_us, bool inclusive);
  void tick(std::int64_t now_us);
  void find_candidates(std::int64_t now_us);
  void score_tracks(std::int64_t now_us, double dt_s);
  void take_candidates(std::int64_t now_us);
  [[nodiscard]] double worth_of(double score, double moved_px) const;
  [[nodiscard]] const Followed* best() const;

  BallTrackerConfig config_;
  Camera camera_;
  std::vector<Eigen::Vector3d> rays_;  // of each pixel
  EventSieve sieve_;
  PlaneFitFlow flow_;
  std::vector<std::int64_t> last_event_us_;  // of each pixel and polarity
  EdgeMap edges_;
  HoughTransform transform_;
  std::vector<Vote> votes_;  // of the last look; room for every edge
  std::vector<Candidate> candidates_;
  std::array<Followed, 4> followed_;
  std::optional<Eigen::Vector3d> rotation_rad_s_;  // of the camera, in its own frame
  std::int64_t now_us_;
  std::optional<std::int64_t> next_tick_us_;
  std::int64_t last_look_us_;
};

}  // namespace saccade
