#include <algorithm>
#include <cmath>

#include "core/time_stamp.h"
#include "core/tracker/ball_tracker.h"
#include "core/tracker/ball_tracker_constants.h"

// The search of BallTracker for circles that are not followed yet.
namespace saccade {
namespace {

using namespace ball_tracker;

bool is_same(const Circle& a, const Circle& b, double px, double r_px) {
  return std::hypot(a.x_px - b.x_px, a.y_px - b.y_px) < px && std::abs(a.r_px - b.r_px) < r_px;
}

/// Of a circle that was found and has no history.
double found_probability(const BestModel& model, const DiscEvidence& evidence, double network_log_odds,
                         const PatchResult& patch = {}) {
  DiscHistory history;
  history.newest = evidence;
  history.network_log_odds = history.network_mean = network_log_odds;
  history.patch = history.patch_mean = patch;
  return disc_probability(model.probability, disc_inputs(evidence, history));
}

}  // namespace

void BallTracker::work_ahead() {
  if (!search_due_us_) return;
  const std::int64_t due_us = *search_due_us_;
  search_due_us_.reset();
  patches_left_ = most_patches;
  judged_count_ = 0;
  run_disc_network(due_us);
  update_seen_rotation(due_us);
  evaluate_candidates(due_us);
  update_patch(due_us);
}

Circle BallTracker::corrected(const Circle& circle, const Circle& by) const {
  return {circle.x_px + by.x_px, circle.y_px + by.y_px,
          std::clamp(circle.r_px + by.r_px, config_.radius_px[0] - 0.5, config_.radius_px[1] + 0.5)};
}

/// The better one of a circle and its correction by PatchNetwork, and its log odds. Takes one or two of the tick's patches.
BallTracker::RefinedCircle BallTracker::refined(const Circle& circle, const Eigen::Vector3d& motion,
                                                std::int64_t now_us) {
  const auto output_of = [&](const Circle& c) {
    --patches_left_;
    const PatchMotion moves = patch_motion(c, motion);
    judged_[judged_count_++] = {now_us, c, moves};
    return run_patch_network(model_->patch, polar_patch(surface_, c, moves, now_us));
  };
  const PatchOutput output = output_of(circle);
  const Circle& off = output.correction;
  const RefinedCircle unchanged{circle, output, false};
  const double off_rings =
      std::max({std::abs(off.x_px), std::abs(off.y_px), std::abs(off.r_px)}) / polar_ring_px(circle.r_px);
  if (patches_left_ == 0 || off_rings < least_correction_rings) return unchanged;
  const Circle moved = corrected(circle, off);
  const RefinedCircle moved_circle{moved, output_of(moved), true};
  const double before = unchanged.result().log_odds;
  const double after = moved_circle.patch.log_odds;
  const bool better = after > before + correction_gain;
  const bool as_good = after > std::max(0.0, before - correction_gain) && off_rings > large_correction_rings;
  return better || as_good ? moved_circle : unchanged;
}

PatchResult BallTracker::RefinedCircle::result() const {
  return {std::clamp(patch.log_odds, -most_patch_log_odds, most_patch_log_odds),
          std::hypot(patch.correction.x_px, patch.correction.y_px), std::abs(patch.correction.r_px)};
}

/// Runs PatchNetwork for the next of the followed circles near which edges have come since its newest patch. Where the log
/// odds pass the gate, the correction is a measurement of the circle.
void BallTracker::update_patch(std::int64_t now_us) {
  const Followed* leader = best();
  if (patches_left_ == 0 ||
      (leader != nullptr && leader->probability > confident && ticks_ % confident_ticks_per_patch != 0))
    return;
  Followed* next = nullptr;
  for (std::size_t i = 0; i < followed_.size(); ++i) {
    Followed& f = followed_[(next_patch_ + i) % followed_.size()];
    if (next == nullptr && f.alive && f.changed) next = &f;
  }
  if (next == nullptr) return;
  next_patch_ = static_cast<std::size_t>(next - followed_.data()) + 1;
  const RefinedCircle found = refined(next->track.shown(), next->motion_px_s(), now_us);
  if (found.corrected) {
    next->track.inflate(inflated_sd_px);
    next->track.correct(found.circle, Eigen::Vector3d::Constant(fit_sd_px));
  }
  if (found.patch.log_odds > least_measured_log_odds) {
    const Eigen::Vector3d sd_px(found.patch.centre_sd_px, found.patch.centre_sd_px, found.patch.radius_sd_px);
    next->track.inflate(sd_px);
    next->track.correct(corrected(found.circle, found.patch.correction), sd_px.cwiseMax(least_patch_sd_px));
  }
  next->patch = found.result();
  next->changed = false;
  step(*next, found.patch, now_us);
}

/// Without joints: the camera's rotation that the edges show, from every n-th of them where there are many.
void BallTracker::update_seen_rotation(std::int64_t now_us) {
  if (rotation_rad_s_ ||
      (rotation_us_ != never_us && saturated_difference(now_us, rotation_us_) < rotation_period_us))
    return;
  rotation_us_ = now_us;
  std::size_t alive = 0;
  edges_.for_each(now_us, [&](const Edge&) { ++alive; });
  const std::size_t stride = alive / max_flows + 1;
  std::size_t i = 0;
  flows_.clear();
  edges_.for_each(now_us, [&](const Edge& edge) {
    if (i++ % stride == 0) flows_.push_back({edge.x, edge.y, edge.along, edge.speed_px_s});
  });
  seen_rotation_rad_s_ = camera_rotation(flows_, camera_, rays_, seen_rotation_rad_s_);
}

void BallTracker::fill_fit(const Circle& c, std::int64_t now_us) {
  fit_.clear();
  edges_.for_each_near(c.x_px, c.y_px, c.r_px + CircleFit::reach_px, now_us, [&](const Edge& edge) {
    fit_.add(now_at(edge, now_us), Eigen::Vector2d(edge.x, edge.y), edge.along, edge.speed_px_s,
             difference_s(now_us, edge.t_us));
  });
}

/// Goes on with the inference of DiscNetwork, or begins the next one. Its circles are candidates. Its log odds at the followed
/// circles are kept for their next update.
void BallTracker::run_disc_network(std::int64_t now_us) {
  if (!network_.busy()) {
    const Followed* leader = best();
    const std::int64_t period_us = leader != nullptr && leader->probability > confident
                                       ? confident_network_period_us
                                       : network_period_us;
    if (inference_us_ != never_us && saturated_difference(now_us, inference_us_) < period_us) return;
    if (events_since_inference_ < fewest_events_of_inference) return;
    events_since_inference_ = 0;
    inference_us_ = now_us;
    network_.begin(now_us);
  }
  if (!network_.work(surface_, multiplications_per_tick)) return;
  for (Followed& f : followed_) {
    if (f.alive) f.network_log_odds = network_log_odds(f.track.shown(), f.image_px_s, now_us);
  }
  for (const DiscNetwork::Found& found : network_.found()) {
    const double r_px = found.circle.r_px;
    if (r_px < config_.radius_px[0] - 1.0 || r_px > config_.radius_px[1] + 1.0) continue;
    candidates_.push({found.circle, network_.found_at_us()});
  }
}

/// Log odds by the network's last result of a circle that moves in the image; at least least_network_log_odds.
double BallTracker::network_log_odds(const Circle& circle, const Eigen::Vector2d& image_px_s,
                                     std::int64_t now_us) const {
  if (network_.found_at_us() == never_us) return least_network_log_odds;
  const double since_s = difference_s(now_us, network_.found_at_us());
  const Circle then{circle.x_px - image_px_s.x() * since_s, circle.y_px - image_px_s.y() * since_s,
                    circle.r_px};
  return std::max(least_network_log_odds, static_cast<double>(network_.about(then).log_odds));
}

/// Evaluates some of the candidates.
void BallTracker::evaluate_candidates(std::int64_t now_us) {
  for (std::size_t i = 0; i < candidates_per_tick && !candidates_.empty(); ++i) {
    const Candidate found = candidates_.pop();
    Circle circle = found.circle;
    fill_fit(circle, found.at_us);
    const Eigen::Vector3d motion = fit_.motion(circle);
    const double since_s = difference_s(now_us, found.at_us);
    circle.x_px += motion.x() * since_s;
    circle.y_px += motion.y() * since_s;
    if (std::max(std::abs(circle.x_px), std::abs(circle.y_px)) < farthest_px) {
      fill_fit(circle, now_us);
      evaluate_candidate(circle, now_us);
    }
    if (candidates_.empty()) end_duplicates();
  }
}

/// Begins a track with a circle where it is more probable than the track whose place it takes.
void BallTracker::evaluate_candidate(const Circle& circle, std::int64_t now_us) {
  const Eigen::Vector3d motion = fit_.motion(circle);
  const DiscEvidence seen = evidence(circle, motion, now_us);
  const double log_odds = network_log_odds(circle, motion.head<2>(), now_us);
  const double probability = found_probability(*model_, seen, log_odds);
  if (corrects_known(circle, probability, now_us)) return;
  NewTrack found{circle, motion, seen, log_odds, {}, probability};
  if (patches_left_ == 0 || place_for(found) == nullptr) return;
  found.refined = refined(circle, motion, now_us);
  if (found.refined.corrected) {
    found.circle = found.refined.circle;
    found.evidence = evidence(found.circle, motion, now_us);
  }
  found.probability = found_probability(*model_, found.evidence, log_odds, found.refined.result());
  if (Followed* place = place_for(found)) follow(found, *place, now_us);
}

/// Whether a found circle is one that is followed. Where it is the better one of the two, the track is corrected.
bool BallTracker::corrects_known(const Circle& circle, double probability, std::int64_t now_us) {
  bool known = false;
  for (Followed& f : followed_) {
    if (!f.alive) continue;
    const Circle c = f.track.shown();
    if (is_same(c, circle, 6.0, 4.0)) {
      if (f.compared_us != now_us) {
        f.compared_us = now_us;
        f.found_probability = found_probability(*model_, evidence(c, f.motion_px_s(), now_us),
                                                network_log_odds(c, f.image_px_s, now_us));
      }
      if (probability > f.found_probability + better_by) {
        f.compared_us = never_us;
        f.track.inflate(inflated_sd_px);
        f.track.correct(circle, Eigen::Vector3d::Constant(fit_sd_px));
        return true;
      }
    }
    known = known || is_same(c, circle, 4.0, 2.0);
  }
  return known;
}

/// The followed circle that a found one takes the place of: where enough circles claim the same disc, the least probable one
/// of these, else the least probable one of all. None where that is more probable.
BallTracker::Followed* BallTracker::place_for(const NewTrack& found) {
  const double reach_px = rival_share * found.circle.r_px;
  Followed* weakest = nullptr;
  std::size_t rivals = 0;
  for (Followed& f : followed_) {
    if (!f.alive || !is_same(f.track.shown(), found.circle, reach_px, reach_px)) continue;
    ++rivals;
    if (weakest == nullptr || f.probability < weakest->probability) weakest = &f;
  }
  if (rivals < max_rivals) {
    weakest = followed_.data();
    for (Followed& f : followed_) {
      if (!weakest->alive) break;
      if (!f.alive || f.probability < weakest->probability) weakest = &f;
    }
  }
  return weakest->alive && new_share * found.probability <= weakest->probability ? nullptr : weakest;
}

void BallTracker::follow(const NewTrack& found, Followed& place, std::int64_t now_us) {
  const Circle& circle = found.circle;
  Followed f;
  f.alive = true;
  f.number = ++births_;
  f.anchor_px = {circle.x_px, circle.y_px};
  f.carried_px_s = camera_flow_px_s(f.anchor_px);
  f.track = CircleTrack(circle, now_us);
  // The edges that are there give its uncertainty.
  edges_.for_each_near(circle.x_px, circle.y_px, circle.r_px + 2.0 * config_.crossing_px, now_us,
                       [&](const Edge& edge) {
                         f.track.measure(edge, 1.0, CircleTrack::Learn::place_and_speed, f.carried_px_s);
                       });
  f.track.set_speed(found.motion_px_s.head<2>() - f.carried_px_s, found.motion_px_s.z());
  f.track.place(circle);
  f.image_px_s = f.carried_px_s + f.track.speed_px_s();
  f.evidence = f.history.newest = found.evidence;
  f.network_log_odds = f.history.network_log_odds = f.history.network_mean = found.network_log_odds;
  f.patch = f.history.patch = f.history.patch_mean = found.refined.result();
  f.history.radius_variance_px2 = f.track.covariance()(2, 2);
  f.probability = new_share * found.probability;
  f.inputs = disc_inputs(f.evidence, f.history);
  f.born_us = now_us;
  place = f;
  step(place, found.refined.patch, now_us);
}

/// Of two circles that have become one the less probable ends.
void BallTracker::end_duplicates() {
  for (Followed& a : followed_) {
    for (Followed& b : followed_) {
      if (&a == &b || !a.alive || !b.alive || a.probability < b.probability) continue;
      if (is_same(a.track.shown(), b.track.shown(), 2.0, 1.5)) b.alive = false;
    }
  }
}

}  // namespace saccade
