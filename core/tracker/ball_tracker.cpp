#include "core/tracker/ball_tracker.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/portable_math.h"
#include "core/time_stamp.h"
#include "core/tracker/ball_tracker_constants.h"
#include "core/tracker/better_of_two.h"
#include "core/tracker/decimated_detector.h"
#include "core/units.h"

namespace saccade {
namespace {

using namespace ball_tracker;

constexpr std::int64_t latest_us = std::numeric_limits<std::int64_t>::max();

/// 0 to 1, by the distance from where an object at rest in the room would be: 1 moves by itself.
double moved_share(double moved_px) {
  return std::clamp((moved_px - moved_begin_px) / (moved_end_px - moved_begin_px), 0.0, 1.0);
}

double silent_s(const CircleTrack& track) { return static_cast<double>(track.silent_us()) * 1e-6; }

/// Probability that a ball has not left since the last event of its outline.
double not_left(const CircleTrack& track, double leaves_per_s) {
  return portable_exp(-silent_s(track) * leaves_per_s);
}

double perimeter_px(const Circle& c) { return 2.0 * std::numbers::pi * c.r_px; }

}  // namespace

void describe(FieldVisitor& v, BallTrackerConfig& c) {
  describe_radius_px(v, c.radius_px);
  v.real("threshold", c.threshold, {0.0, 1.0}, "probability from which on a circle is taken for the ball");
  v.section(
      "flow", [&](FieldVisitor& w) { describe(w, c.flow); }, "plane-fit flow");
  v.integer("burst_us", c.burst_us, {0, 1e6}, "pause from which on a pixel's event is a new edge");
  v.integer("edges_per_region", c.edges_per_region, {1, 256}, "kept of each 8 x 8 pixels");
  v.real("crossing_px", c.crossing_px, {0.5, 20.0}, "how far an edge moves on while it is kept");
  v.integer("longest_us", c.longest_us, {1e3, 1e7}, "for which an edge is kept at most");
  v.real("hold_s", c.hold_s, {0.0, 60.0}, "for which a circle without events is held");
  v.integer("flows_per_ms", c.flows_per_ms, {10, 1e6}, "events that get a flow in a ms; of more, every n-th");
  v.model("model", c.model, "weights of the networks, an NPZ file; empty: those of this program");
  const std::string problem = problem_of(c.model);
  v.require(problem.empty(), "model", problem, "the arrays of models/best/weights.npz");
}

BallTracker::BallTracker(const BallTrackerConfig& config, const Camera& camera)
    : BallTracker(config, camera, best_model_of(config.model)) {}

BallTracker::BallTracker(const BallTrackerConfig& config, const Camera& camera,
                         std::shared_ptr<const BestModel> model)
    : config_(check_config("detector", config)),
      model_(std::move(model)),
      camera_(camera),
      sieve_(camera.size),
      flow_(config.flow, camera.size),
      edges_(camera.size, static_cast<int>(config.edges_per_region)),
      surface_(camera.size),
      network_(model_, camera.size, config.radius_px[0], config.radius_px[1]),
      now_us_(never_us),
      rotation_us_(never_us),
      inference_us_(never_us),
      flows_left_(config.flows_per_ms) {
  rays_.reserve(static_cast<std::size_t>(camera.size.pixels()));
  for (int y = 0; y < camera.size.height; ++y) {
    for (int x = 0; x < camera.size.width; ++x) rays_.push_back(camera.ray(x, y));
  }
  flows_.reserve(max_flows);
}

void BallTracker::set_motion(const CameraMotion* motion) {
  rotation_rad_s_.reset();
  if (motion != nullptr) rotation_rad_s_ = motion->angular_velocity_rad_s;
}

Eigen::Vector2d BallTracker::camera_flow_px_s(const Eigen::Vector2d& at) const {
  if (!rotation_rad_s_) return Eigen::Vector2d::Zero();
  // The lens is only known inside the image: further out as at its border.
  const Eigen::Vector3d ray =
      camera_.ray(std::clamp(at.x(), 0.0, static_cast<double>(camera_.size.width - 1)),
                  std::clamp(at.y(), 0.0, static_cast<double>(camera_.size.height - 1)));
  return camera_.rotational_flow_px_s(ray, *rotation_rad_s_);
}

Eigen::Vector2d BallTracker::camera_flow_px_s(const Edge& edge) const {
  if (!rotation_rad_s_) return Eigen::Vector2d::Zero();
  const Eigen::Vector3d& ray = rays_[static_cast<std::size_t>(edge.y * camera_.size.width + edge.x)];
  return camera_.rotational_flow_px_s(ray, *rotation_rad_s_);
}

/// Image motion of the background by the joints or else by the edges.
Eigen::Vector2d BallTracker::background_px_s(const Eigen::Vector2d& at) const {
  if (rotation_rad_s_) return camera_flow_px_s(at);
  if (seen_rotation_rad_s_.isZero()) return Eigen::Vector2d::Zero();
  const int x = static_cast<int>(std::clamp(at.x(), 0.0, static_cast<double>(camera_.size.width - 1)));
  const int y = static_cast<int>(std::clamp(at.y(), 0.0, static_cast<double>(camera_.size.height - 1)));
  return camera_.rotational_flow_px_s(rays_[static_cast<std::size_t>(y * camera_.size.width + x)],
                                      seen_rotation_rad_s_);
}

PatchMotion BallTracker::patch_motion(const Circle& circle, const Eigen::Vector3d& motion_px_s) const {
  return {motion_px_s.head<2>(), background_px_s({circle.x_px, circle.y_px}), motion_px_s.z()};
}

/// Where an edge has moved on to: with the image where the camera turns, along its own flow else.
Eigen::Vector2d BallTracker::now_at(const Edge& edge, std::int64_t now_us) const {
  const Eigen::Vector2d at(edge.x, edge.y);
  const double age_s = difference_s(now_us, edge.t_us);
  const Eigen::Vector2d image = camera_flow_px_s(edge);
  if (image.squaredNorm() > camera_moves_px_s * camera_moves_px_s) return at + image * age_s;
  return at + edge.along * (edge.speed_px_s * age_s);
}

DiscEvidence BallTracker::evidence(const Circle& c, const Eigen::Vector3d& motion,
                                   std::int64_t now_us) const {
  const Eigen::Vector2d centre(c.x_px, c.y_px);
  DiscEvidenceCollector collector(c, motion, background_px_s(centre));
  // Edges are kept where they came: some have moved on by more than crossing_px.
  const double reach_px = c.r_px + DiscEvidenceCollector::reach_px + 3.0;
  edges_.for_each_near(c.x_px, c.y_px, reach_px, now_us, [&](const Edge& edge) {
    const double age_s = difference_s(now_us, edge.t_us);
    Eigen::Vector2d offset = Eigen::Vector2d(edge.x, edge.y) + motion.head<2>() * age_s - centre;
    const double distance = offset.norm();
    if (distance > 1.0) offset *= 1.0 + motion.z() * age_s / distance;
    collector.add(offset, edge.along, edge.speed_px_s);
  });
  return collector.evidence();
}

void BallTracker::process(std::span<const Event> events, const CameraMotion* motion) {
  work_ahead();
  set_motion(motion);
  for (std::size_t i = 0; i < events.size(); ++i) {
    if (i + prefetched_events < events.size()) {
      const Event& later = events[i + prefetched_events];
      if (!sieve_.is_outside(later)) {
        surface_.prefetch(later);
        flow_.prefetch(later);
      }
    }
    const Event& event = events[i];
    if (!sieve_.accept(event)) continue;
    run_until(event.t_us, false);
    work_ahead();
    surface_.add(event);
    ++events_since_inference_;
    if (!flow_.add_first(event, config_.burst_us)) continue;
    ++events_of_tick_;
    for (Followed& f : followed_) {
      if (!f.alive || !f.slow) continue;
      const Circle c = f.track.shown();
      const double x = event.x - c.x_px;
      const double y = event.y - c.y_px;
      const double reach_px = c.r_px + near_px;
      if (x * x + y * y > reach_px * reach_px) continue;
      const double since_tick_s = difference_s(event.t_us, f.track.time_us());
      f.silhouette.add({event.x, event.y}, f.track.carried_px() + f.image_px_s * since_tick_s, event.t_us);
    }
    if (flows_left_ == 0 || ++since_flow_ < nth_event_) continue;
    since_flow_ = 0;
    --flows_left_;
    if (const auto flow = flow_.at(event)) add_edge(event, *flow);
  }
}

void BallTracker::add_edge(const Event& event, const NormalFlow& flow) {
  const Eigen::Vector2d gradient(flow.dt_dx_us_px, flow.dt_dy_us_px);
  const double slowness = gradient.norm();
  if (slowness < fastest_us_px) return;
  const double life_us = std::clamp(config_.crossing_px * slowness, shortest_life_us,
                                    std::max(shortest_life_us, static_cast<double>(config_.longest_us)));
  const Edge edge{event.t_us,
                  saturated_sum(event.t_us, static_cast<std::int64_t>(life_us)),
                  gradient / slowness,
                  1e6 / slowness,
                  event.x,
                  event.y};
  edges_.add(edge);
  for (Followed& f : followed_) {
    if (!f.alive) continue;
    const Circle c = f.track.shown();
    const double x = edge.x - c.x_px;
    const double y = edge.y - c.y_px;
    if (std::abs(std::sqrt(x * x + y * y) - c.r_px) > near_px) continue;
    f.fresh_edges += 1.0;
    f.changed = true;
    if (f.track.measure(edge, f.clarity, CircleTrack::Learn::place, f.carried_px_s)) {
      f.fresh_on_outline += 1.0;
      f.history.silent_px = 0.0;
    } else {
      f.history.silent_px += 1.0 / perimeter_px(c);
    }
  }
}

void BallTracker::advance_to(std::int64_t now_us, const CameraMotion* motion) {
  work_ahead();
  set_motion(motion);
  run_until(now_us, true);
}

/// Brings what happens at every tick up to t_us.
void BallTracker::run_until(std::int64_t t_us, bool inclusive) {
  if (t_us < now_us_) return;
  now_us_ = t_us;
  // Ticks are at whole ms. Beyond the latest time stamp that 64 bits hold there is none.
  const auto first_tick = [&] {
    const std::int64_t since_tick_us = (t_us % tick_us + tick_us) % tick_us;
    return saturated_sum(t_us, tick_us - since_tick_us);
  };
  if (!next_tick_us_) next_tick_us_ = first_tick();
  while (*next_tick_us_ != latest_us && (*next_tick_us_ < t_us || (inclusive && *next_tick_us_ == t_us))) {
    work_ahead();
    if (best() == nullptr && edges_.last_end_us() < *next_tick_us_) {
      next_tick_us_ = first_tick();
      start_tick();
      return;
    }
    tick(*next_tick_us_);
    *next_tick_us_ = saturated_sum(*next_tick_us_, tick_us);
  }
}

/// Sets which events of the next tick get a flow: every n-th, by the number of events in the last one.
void BallTracker::start_tick() {
  nth_event_ = events_of_tick_ / config_.flows_per_ms + 1;
  flows_left_ = 2 * config_.flows_per_ms;  // where the rate rises
  events_of_tick_ = 0;
}

void BallTracker::tick(std::int64_t now_us) {
  start_tick();
  for (Followed& f : followed_) {
    if (!f.alive) continue;
    f.fresh_edges *= fresh_left;
    f.fresh_on_outline *= fresh_left;
    f.anchor_px += background_px_s(f.anchor_px) * tick_s;
    f.track.predict(now_us, camera_flow_px_s(f.track.centre()));
    f.anchor_px += (f.track.centre() - f.anchor_px) * (tick_s / anchor_s);
    const double moved_px = (f.track.centre() - f.anchor_px).norm();
    f.history.moved_share = moved_share(moved_px);
    f.history.moved_most_share = std::max(f.history.moved_most_share, f.history.moved_share);
    f.history.moved_radii = moved_px / f.track.circle().r_px;
    f.track.rest_if_silent(f.history.silhouette > gaze_follows_silhouette ? camera_flow_px_s(f.track.centre())
                                                                          : Eigen::Vector2d::Zero());
    f.carried_px_s = camera_flow_px_s(f.track.centre());
    f.image_px_s = f.track.speed_px_s() + f.carried_px_s;
    f.slow = f.image_px_s.norm() < silhouette_fastest_px_s;
    f.track.bound(config_.radius_px[0], config_.radius_px[1]);
    const Eigen::Vector2d at = f.track.centre();
    const bool inside =
        at.x() >= 0.0 && at.y() >= 0.0 && at.x() < camera_.size.width && at.y() < camera_.size.height;
    f.alive = inside && static_cast<double>(f.track.silent_us()) <= config_.hold_s * 1e6;
  }
  if (++ticks_ % ticks_per_update == 0) {
    for (Followed& f : followed_) {
      if (!f.alive) continue;
      if (ticks_ % ticks_per_silhouette == 0) update_silhouette(f, now_us);
      update_probability(f, now_us);
    }
  }
  if (now_us >= search_from_us_) search_due_us_ = now_us;
}

void BallTracker::update_silhouette(Followed& f, std::int64_t now_us) {
  f.history.silhouette = 0.0;
  const auto silhouette = f.silhouette.fit(f.track.shown(), f.track.carried_px(), now_us);
  if (!silhouette) return;
  const double speed = f.image_px_s.norm();
  const double slow = 1.0 / (1.0 + speed * speed / (silhouette_slow_px_s * silhouette_slow_px_s));
  f.track.correct(silhouette->circle, silhouette->sd_px.cwiseMax(silhouette_least_sd_px) / slow);
  const double shown = silhouette->seen * silhouette->emptiness * silhouette->emptiness;
  f.history.silhouette = shown * shown * silhouette->tightness * slow;
}

/// Updates the evidence once enough edges have come near the circle. Fewer are noise, and silence is no evidence.
void BallTracker::update_probability(Followed& f, std::int64_t now_us) {
  const double length_px = perimeter_px(f.track.circle());
  const bool enough = f.fresh_edges >= std::max(fewest_fresh, fresh_px * length_px);
  if (enough) {
    const DiscEvidence newest = evidence(f.track.shown(), f.motion_px_s(), now_us);
    const double clutter_px2 =
        density_of(std::min(newest[Evidence::radial_outside], newest[Evidence::radial_inside]));
    const double visibility = std::exp(-clutter_px2 / clutter_hides_px2);
    const double weight = least_weight + (1.0 - least_weight) * visibility;
    const double share = 1.0 - std::exp(-f.fresh_edges / length_px * weight / memory_px);
    f.evidence.blend(newest, share);
    f.history.newest = newest;
    f.history.network_log_odds = f.network_log_odds;
    f.history.patch = f.patch;
    f.history.patch_mean.blend(f.patch, share);
    f.history.network_mean += share * (f.network_log_odds - f.history.network_mean);
    f.history.on_ring_share += share * (f.fresh_on_outline / f.fresh_edges - f.history.on_ring_share);
    f.history.followed_px += weight * f.fresh_on_outline / length_px;
    f.clarity = std::max(least_clarity, (1.0 - std::exp(-newest[Evidence::ring_to_sides])) * visibility);
    f.fresh_edges = f.fresh_on_outline = 0.0;
  }
  if (!enough && f.history.silhouette <= 0.0) return;
  f.history.radius_variance_px2 = f.track.covariance()(2, 2);
  f.inputs = disc_inputs(f.evidence, f.history);
  f.probability = disc_probability(model_->probability, f.inputs);
}

/// The existence probability with the decay since the last edge: the ball may have left without events.
double BallTracker::existence_probability(const Followed& f) {
  return f.existence.probability * not_left(f.track, f.existence.leaves_per_s);
}

/// A step of the circle's network, with a patch that was evaluated at it.
void BallTracker::step(Followed& f, const PatchOutput& patch, std::int64_t now_us) {
  TrackStep s;
  s.inputs = f.inputs;
  s.probability = f.probability;
  s.followed = 0;
  for (const Followed& other : followed_) {
    if (!other.alive) continue;
    ++s.followed;
    if (&other != &f) s.rival = std::max(s.rival, other.probability * not_left(other.track, 1.0 / stays_s));
  }
  if (f.steps > 0) s.since_step_s = difference_s(now_us, f.step_us);
  s.age_s = difference_s(now_us, f.born_us);
  s.silent_s = silent_s(f.track);
  const Circle c = f.track.circle();
  s.border_radii =
      std::min({c.x_px, c.y_px, camera_.size.width - 1 - c.x_px, camera_.size.height - 1 - c.y_px}) / c.r_px;
  f.step_inputs = track_inputs(s, patch);
  f.existence = run_track_network(model_->track, f.step_inputs, f.memory);
  f.step_us = now_us;
  ++f.steps;
}

/// The most probable circle. Of several discs in view the one that has moved by itself is the ball: one that has not
/// competes with a share of its probability, and one without events with less the longer it has none.
const BallTracker::Followed* BallTracker::best() const {
  const auto rank = [](const Followed& f) {
    return f.existence.probability * not_left(f.track, 1.0 / stays_s) *
           (at_rest_share + (1.0 - at_rest_share) * f.history.moved_most_share);
  };
  const Followed* best = nullptr;
  for (const Followed& f : followed_) {
    if (f.alive && (best == nullptr || rank(f) > rank(*best))) best = &f;
  }
  return best;
}

Circle BallTracker::circle_now(const Followed& f) const {
  return f.track.circle_at(now_us_, camera_flow_px_s(f.track.centre()));
}

Estimate BallTracker::estimate() {
  const Followed* f = best();
  if (f == nullptr) return {};
  const Eigen::Matrix3d covariance =
      covariance_scale * f->track.covariance() + Eigen::Vector3d(model_sd_px[0] * model_sd_px[0],
                                                                 model_sd_px[1] * model_sd_px[1],
                                                                 model_sd_px[2] * model_sd_px[2])
                                                     .asDiagonal()
                                                     .toDenseMatrix();
  return {true, f->track.silent_us() >= tick_us, circle_now(*f), existence_probability(*f), covariance};
}

std::size_t BallTracker::tracks(std::span<Track, most_tracks> tracks) const {
  std::size_t count = 0;
  for (const Followed& f : followed_) {
    if (!f.alive) continue;
    tracks[count++] = {f.number,
                       f.steps,
                       circle_now(f),
                       f.image_px_s,
                       f.existence,
                       f.history.moved_most_share,
                       f.track.silent_us(),
                       f.step_inputs};
  }
  return count;
}

std::unique_ptr<Detector> make_ball_tracker(const BallTrackerConfig& config, const Camera& camera) {
  check_config("detector", config);
  const std::shared_ptr<const BestModel> model = best_model_of(config.model);
  const auto [smallest, largest] = config.radius_px;
  const auto on_all_pixels = [&](double to_px) {
    BallTrackerConfig fine = config;
    fine.radius_px[1] = to_px;
    return std::make_unique<BallTracker>(fine, camera, model);
  };
  if (largest <= largest_fitted_px) return on_all_pixels(largest);
  const int step = static_cast<int>(std::ceil(largest / largest_decimated_px));
  const bool small_too = smallest < step * smallest_decimated_px;
  BallTrackerConfig coarse = config;
  coarse.radius_px = {std::floor((small_too ? smallest_of_two_px : smallest) / step),
                      std::ceil(largest / step)};
  auto large = std::make_unique<DecimatedDetector>(
      std::make_unique<BallTracker>(coarse, decimated(camera, step), model), camera.size, step);
  if (!small_too) return large;
  return std::make_unique<BetterOfTwo>(on_all_pixels(largest_fitted_px), std::move(large));
}

}  // namespace saccade
