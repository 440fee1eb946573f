#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "core/detector_parts.h"
#include "core/detector_views.h"
#include "core/flow/camera_rotation.h"
#include "core/flow/plane_fit_flow.h"
#include "core/reserved_vector.h"
#include "core/time_surface.h"
#include "core/tracker/best_model.h"
#include "core/tracker/circle_fit.h"
#include "core/tracker/circle_track.h"
#include "core/tracker/disc_evidence.h"
#include "core/tracker/disc_network.h"
#include "core/tracker/disc_probability.h"
#include "core/tracker/edge_map.h"
#include "core/tracker/patch_network.h"
#include "core/tracker/polar_patch.h"
#include "core/tracker/silhouette.h"
#include "core/tracker/track_network.h"

namespace saccade {

/// Configuration of the recommended detector, `best`.
struct BallTrackerConfig {
  std::array<double, 2> radius_px = {10, 35};  ///< smallest and largest radius, whole numbers
  double threshold = 0.5;                      ///< probability from which on a circle is taken for the ball
  PlaneFitFlowConfig flow = {.max_age_us = 400'000};  ///< down to 2.5 px/s
  /// An event that follows the first one of its pixel and polarity sooner than this is of the same edge.
  std::int64_t burst_us = 500;
  std::int64_t edges_per_region = 24;   ///< kept of each 8 x 8 pixels
  double crossing_px = 2.5;             ///< an edge is kept while it moves on so far
  std::int64_t longest_us = 1'000'000;  ///< and no longer than this
  double hold_s = 3.0;                  ///< a circle that makes no events is held for so long
  std::int64_t flows_per_ms = 600;      ///< events that get a flow; beyond that every n-th event does
  ModelFile model;                      ///< the networks' weights
};

/// Keys: radius_px, threshold, flow, burst_us, edges_per_region, crossing_px, longest_us, hold_s, flows_per_ms, model.
void describe(FieldVisitor& v, BallTrackerConfig& config);

/// The recommended detector: follows up to eight circles on the moving edges of the image and returns the one that is
/// most probably the ball, with that probability as score.
///
/// 1. Events with a normal flow (plane fit), the first of each burst of a pixel, become edges, kept by region for as long
///    as they take to move on by crossing_px (EdgeMap): thin outlines at any speed, whatever else moves.
/// 2. A network finds discs in the time surface, with a part of its work in every ms (DiscNetwork). Their motion comes from the
///    edges near them (CircleFit).
/// 3. Circles are followed edge by edge (CircleTrack), carried along by the camera's own rotation where joints tell it.
/// 4. Figures of the edges near a circle (DiscEvidence) are averaged over the last pixels of its motion. A circle
///    without edges keeps them; its probability decays, because the ball may have left without events.
/// 5. A ball that the gaze follows makes hardly any events while the background does: its silhouette in the background's
///    events (Silhouette) is a measurement of the circle, and evidence too.
/// 6. Objects that move against the background are distinguished from those at rest in the room. The background's motion
///    comes from the joints, or else from the edges (camera_rotation).
/// 7. From the time surface around a circle, in polar coordinates, PatchNetwork estimates log odds, a correction of the
///    circle and its standard deviations.
/// 8. Evidence, the networks' log odds and the history of a circle give the probability at an instant that it is the ball
///    (disc_probability); from patch to patch a network with memory turns what the circle has shown into its existence
///    probability, calibrated (track_network).
///
/// The work of a ms is bounded: flows_per_ms flows, about 6 million multiplications of DiscNetwork, 8 candidates, 4 patches; an
/// event beyond that only leaves its time stamp. Everything happens at instants of 1 ms of the stream's own time, so that the
/// estimate does not depend on how events come in batches, unless leave_out_work_before() is called.
/// Words: the ball is the object; a circle is a hypothesis of its outline, first a candidate, then a track; a disc is the
/// region inside a circle; a patch is the time surface around a circle in polar coordinates.
/// After: paper, section V (future work); regions after Glover, Dinale, Bartolozzi et al. (event surfaces SCARF and EROS
/// of the same group).
class BallTracker final : public Detector, public DetectorViews {
 public:
  /// Throws InputError for a configuration out of range.
  BallTracker(const BallTrackerConfig& config, const Camera& camera);
  /// The same with a model that several share, in place of the config's.
  BallTracker(const BallTrackerConfig& config, const Camera& camera, std::shared_ptr<const BestModel> model);

  void process(std::span<const Event> events, const CameraMotion* motion) override;
  void advance_to(std::int64_t now_us, const CameraMotion* motion) override;
  [[nodiscard]] Estimate estimate() override;
  /// The search of the last tick for circles that are not followed.
  void work_ahead() override;
  /// The searches of ms before it.
  void leave_out_work_before(std::int64_t t_us) override { search_from_us_ = t_us; }
  [[nodiscard]] double threshold() const override { return config_.threshold; }
  [[nodiscard]] RejectedEvents rejected() const override { return sieve_.rejected(); }
  [[nodiscard]] std::unique_ptr<Detector> copy() const override {
    return std::make_unique<BallTracker>(*this);
  }

  /// What the score of a followed circle is made of, to fit it (tests/training/track_log.cpp).
  struct Track {
    std::uint64_t number;  ///< of its birth
    std::uint64_t steps;   ///< of its network since
    Circle circle;         ///< now
    Eigen::Vector2d image_px_s;
    TrackExistence existence;
    double moved_most_share;
    std::int64_t silent_us;  ///< since the last edge on its outline
    TrackInputs inputs;      ///< of the last step
  };
  static constexpr std::size_t most_tracks = 8;
  /// The followed circles, as many as there are.
  [[nodiscard]] std::size_t tracks(std::span<Track, most_tracks> tracks) const;

  /// Motion of a circle whose centre and radius move so, and that of the background there.
  [[nodiscard]] PatchMotion patch_motion(const Circle& circle, const Eigen::Vector3d& motion_px_s) const;

  /// A polar patch that PatchNetwork has judged, to train it (tests/training/track_log.cpp).
  struct JudgedPatch {
    std::int64_t t_us;
    Circle circle;
    PatchMotion motion;
  };
  static constexpr std::size_t most_patches = 4;  ///< of a tick
  /// Those of the last tick's search.
  [[nodiscard]] std::span<const JudgedPatch> judged_patches() const {
    return std::span(judged_).first(judged_count_);
  }

 private:
  struct Followed {
    bool alive = false;
    CircleTrack track;
    Silhouette silhouette;
    DiscEvidence evidence;  ///< averaged over the last pixels of motion
    DiscHistory history;
    double network_log_odds = least_network_log_odds;  ///< of the newest inference
    PatchResult patch;                                 ///< of the newest patch
    bool changed = false;                              ///< since then
    DiscInputs inputs{};
    double probability = 0.0;  ///< at this instant, by these inputs
    TrackMemory memory{};
    TrackInputs step_inputs{};
    TrackExistence existence;
    std::uint64_t number = 0, steps = 0;
    std::int64_t born_us = 0, step_us = 0;  ///< step_us: of the last step
    double found_probability = 0.0;         ///< as if it had just been found, at compared_us
    std::int64_t compared_us = std::numeric_limits<std::int64_t>::min();
    double clarity = 1.0;      ///< share of the edges near the circle that are of its outline
    double fresh_edges = 0.0;  ///< near it since the last update of the evidence
    double fresh_on_outline = 0.0;
    Eigen::Vector2d anchor_px = Eigen::Vector2d::Zero();     ///< where it would be if it stood in the room
    Eigen::Vector2d carried_px_s = Eigen::Vector2d::Zero();  ///< image motion by the joints, at it
    Eigen::Vector2d image_px_s = Eigen::Vector2d::Zero();    ///< its own motion in the image
    bool slow = true;                                        ///< may have a silhouette

    [[nodiscard]] Eigen::Vector3d motion_px_s() const {
      return {image_px_s.x(), image_px_s.y(), track.growth_px_s()};
    }
  };
  struct Candidate {
    Circle circle;
    std::int64_t at_us;
  };
  /// A circle, corrected by PatchNetwork or not, and the network's output for it.
  struct RefinedCircle {
    Circle circle;
    PatchOutput patch;
    bool corrected;

    [[nodiscard]] PatchResult result() const;  ///< for the probability
  };
  /// A circle that begins a track, and its evidence.
  struct NewTrack {
    Circle circle;
    Eigen::Vector3d motion_px_s;
    DiscEvidence evidence;
    double network_log_odds;
    RefinedCircle refined;
    double probability;
  };
  /// Candidates for a new track (birth), oldest first; one that comes when the queue is full is dropped.
  class CandidateQueue {
   public:
    [[nodiscard]] bool empty() const { return count_ == 0; }
    void push(const Candidate& found) {
      if (count_ == found_.size()) return;
      found_[(first_ + count_++) % found_.size()] = found;
    }
    Candidate pop() {
      const Candidate found = found_[first_];
      first_ = (first_ + 1) % found_.size();
      --count_;
      return found;
    }

   private:
    std::array<Candidate, 24> found_;
    std::size_t first_ = 0, count_ = 0;
  };

  void set_motion(const CameraMotion* motion);
  [[nodiscard]] Eigen::Vector2d camera_flow_px_s(const Eigen::Vector2d& at_px) const;
  [[nodiscard]] Eigen::Vector2d camera_flow_px_s(const Edge& edge) const;
  [[nodiscard]] Eigen::Vector2d background_px_s(const Eigen::Vector2d& at_px) const;
  [[nodiscard]] Eigen::Vector2d now_at(const Edge& edge, std::int64_t now_us) const;
  [[nodiscard]] DiscEvidence evidence(const Circle& circle, const Eigen::Vector3d& motion_px_s,
                                      std::int64_t now_us) const;
  [[nodiscard]] Circle circle_now(const Followed& f) const;
  [[nodiscard]] static double existence_probability(const Followed& f);
  void step(Followed& f, const PatchOutput& patch, std::int64_t now_us);
  [[nodiscard]] const Followed* best() const;

  void add_edge(const Event& event, const NormalFlow& flow);
  void run_until(std::int64_t t_us, bool inclusive);
  void start_tick();
  void tick(std::int64_t now_us);
  void update_silhouette(Followed& f, std::int64_t now_us);
  void update_probability(Followed& f, std::int64_t now_us);

  // The search for circles that are not followed (ball_tracker_search.cpp).
  void update_seen_rotation(std::int64_t now_us);
  void fill_fit(const Circle& circle, std::int64_t now_us);
  [[nodiscard]] bool corrects_known(const Circle& circle, double probability, std::int64_t now_us);
  [[nodiscard]] Followed* place_for(const NewTrack& found);
  void follow(const NewTrack& found, Followed& place, std::int64_t now_us);
  void run_disc_network(std::int64_t now_us);
  [[nodiscard]] double network_log_odds(const Circle& circle, const Eigen::Vector2d& image_px_s,
                                        std::int64_t now_us) const;
  void evaluate_candidates(std::int64_t now_us);
  void evaluate_candidate(const Circle& circle, std::int64_t now_us);
  void end_duplicates();
  [[nodiscard]] RefinedCircle refined(const Circle& circle, const Eigen::Vector3d& motion_px_s,
                                      std::int64_t now_us);
  void update_patch(std::int64_t now_us);
  /// The circle with the correction added, its radius within radius_px.
  [[nodiscard]] Circle corrected(const Circle& circle, const Circle& by) const;

  BallTrackerConfig config_;
  std::shared_ptr<const BestModel> model_;
  Camera camera_;
  std::vector<Eigen::Vector3d> rays_;  // of each pixel
  EventSieve sieve_;
  PlaneFitFlow flow_;
  EdgeMap edges_;
  TimeSurface surface_;
  DiscNetwork network_;
  CircleFit fit_;
  std::array<Followed, most_tracks> followed_;
  std::optional<Eigen::Vector3d> rotation_rad_s_;  // of the camera by the joints, its own frame
  Eigen::Vector3d seen_rotation_rad_s_ = Eigen::Vector3d::Zero();  // by the edges, where joints are missing
  std::int64_t now_us_;
  std::optional<std::int64_t> next_tick_us_;
  std::optional<std::int64_t> search_due_us_;  // the last tick, until its search is done
  std::int64_t search_from_us_ = std::numeric_limits<std::int64_t>::min();  // ticks before have none
  std::uint64_t ticks_ = 0;           // so far, those without edges and circles left out
  ReservedVector<FlowSample> flows_;  // of the seen rotation
  std::int64_t rotation_us_;          // when that was estimated
  std::int64_t inference_us_;         // when DiscNetwork's present or newest inference began
  std::uint64_t events_since_inference_ = 0;
  CandidateQueue candidates_;
  std::uint64_t births_ = 0;
  std::size_t next_patch_ = 0;  // of followed_
  int patches_left_ = 0;        // of this tick
  std::array<JudgedPatch, most_patches> judged_;
  std::size_t judged_count_ = 0;
  // Flows of this tick: every nth_event_ event gets one.
  std::int64_t flows_left_, nth_event_ = 1, since_flow_ = 0, events_of_tick_ = 0;
};

/// BallTracker, with radii beyond those that it is fitted for (above 80 px) on every n-th pixel (DecimatedDetector), where n is
/// the smallest number with which the largest radius is at most 40 of these pixels. Keys in pixels other than radius_px
/// are then in these pixels. If the smallest radius is less than 5 of these pixels, a second BallTracker searches radii
/// up to 80 px on all pixels, the first one for those from 60 px on (BetterOfTwo).
/// Throws InputError for a configuration out of range.
[[nodiscard]] std::unique_ptr<Detector> make_ball_tracker(const BallTrackerConfig& config,
                                                          const Camera& camera);

}  // namespace saccade
