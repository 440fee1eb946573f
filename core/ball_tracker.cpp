#include "core/ball_tracker.h"

#include <bit>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/small_solve.h"
#include "core/time_stamp.h"
#include "core/units.h"

namespace saccade {
namespace {

constexpr std::int64_t tick_us = 1'000;
constexpr double tick_s = 1e-3;
constexpr std::int64_t never_us = std::numeric_limits<std::int64_t>::min();
constexpr std::int64_t latest_us = std::numeric_limits<std::int64_t>::max();
constexpr std::int64_t look_following_us = 5'000;
constexpr std::int64_t look_searching_us = 2'000;
constexpr double following_score = 0.1;
constexpr std::size_t max_candidates = 4;

constexpr double near_px = 6.0;  // of a circle: what comes further outside does not concern it

// Edges.
constexpr double fastest_us_px = 10.0;  // steeper flows are noise
constexpr double shortest_life_us = 1'000.0;
constexpr double camera_moves_px_s = 30.0;  // from here on its flow is surer than one measured at a pixel

// The outline of a circle.
constexpr double outline_px = 1.5;  // half its width
constexpr double inner_px = 2.0;    // further inside nothing should be seen
constexpr double outer_begin_px = 2.5, outer_end_px = 5.5;
constexpr double sector_px = 2.0;
constexpr int min_sectors = 8, max_sectors = 32;
constexpr double inner_penalty_px2 = 3.0;
constexpr double clutter_per_px2 = 0.2;  // edges around a circle that hide it

// Holes.
constexpr double hole_slow_px_s = 40.0;    // faster through the image a ball shows by its own events
constexpr double hole_least_sd_px = 0.35;  // of one look; looks share most of their events
constexpr double following_hole = 0.4;

// Scores.
constexpr double rise_s = 0.06, fall_s = 0.5, lost_s = 0.02, forget_s = 1.0;
constexpr double lost_quality = 0.12;
constexpr double full_activity_per_px = 0.3;
constexpr double silence_share = 0.93;
constexpr double birth_quality = 0.25, birth_share = 0.6;
constexpr double fit_sd_px = 0.7;  // of a fitted circle
constexpr double better_by = 0.1, fit_clarity = 0.3;
constexpr double in_the_room_share = 0.5;
constexpr double anchor_s = 0.6, moved_begin_px = 2.0, moved_end_px = 6.0;
constexpr double candidate_share = 0.3;

double distance_px(const Circle& a, const Circle& b) { return std::hypot(a.x_px - b.x_px, a.y_px - b.y_px); }

bool is_same(const Circle& a, const Circle& b, double px, double r_px) {
  return distance_px(a, b) < px && std::abs(a.r_px - b.r_px) < r_px;
}

/// How surely something moves by itself that is so far from where it would be if it stood in the room.
double moved_share(double moved_px) {
  return std::clamp((moved_px - moved_begin_px) / (moved_end_px - moved_begin_px), 0.0, 1.0);
}

BallTrackerConfig checked(const BallTrackerConfig& config) {
  check_config("detector", config);
  return config;
}

}  // namespace

void describe(FieldVisitor& v, BallTrackerConfig& c) {
  describe_radius_px(v, c.radius_px);
  v.real("threshold", c.threshold, {0.0, 1.0}, "score taken for the ball");
  v.real("arc_deg", c.arc_deg, {0.5, 90.0}, "half-width of an arc of votes");
  v.section(
      "flow", [&](FieldVisitor& w) { describe(w, c.flow); }, "plane-fit flow");
  v.integer("burst_us", c.burst_us, {0, 1e6}, "pause from which on a pixel's event is a new edge");
  v.integer("edges_per_region", c.edges_per_region, {1, 256}, "kept of each 8 x 8 pixels");
  v.real("crossing_px", c.crossing_px, {0.5, 20.0}, "how far an edge moves on while it is kept");
  v.integer("longest_us", c.longest_us, {1e3, 1e7}, "for which an edge is kept at most");
  v.real("hold_s", c.hold_s, {0.0, 60.0}, "for which a circle without events is held");
}

BallTracker::BallTracker(const BallTrackerConfig& config, const Camera& camera)
    : config_(checked(config)),
      camera_(camera),
      sieve_(camera.size),
      flow_(config.flow, camera.size),
      last_event_us_(2 * static_cast<std::size_t>(camera.size.pixels()), never_us),
      edges_(camera.size, static_cast<int>(config.edges_per_region)),
      transform_(camera.size, static_cast<int>(config.radius_px[0]), static_cast<int>(config.radius_px[1]),
                 config.arc_deg * rad_per_deg),
      now_us_(never_us),
      last_look_us_(never_us) {
  rays_.reserve(static_cast<std::size_t>(camera.size.pixels()));
  for (int y = 0; y < camera.size.height; ++y) {
    for (int x = 0; x < camera.size.width; ++x) rays_.push_back(camera.ray(x, y));
  }
  votes_.reserve(edges_.capacity());
  candidates_.reserve(max_candidates);
}

void BallTracker::know(const CameraMotion* motion) {
  rotation_rad_s_.reset();
  if (motion != nullptr) rotation_rad_s_ = motion->angular_velocity_rad_s;
}

Eigen::Vector2d BallTracker::camera_flow_px_s(const Eigen::Vector2d& at) const {
  if (!rotation_rad_s_) return Eigen::Vector2d::Zero();
  // What is known of a lens ends with the image: further out as at its border.
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

/// Where an edge has moved on to: with the image where the camera turns, along its own flow else.
Eigen::Vector2d BallTracker::now_at(const Edge& edge, std::int64_t now_us) const {
  const Eigen::Vector2d at(edge.x, edge.y);
  const double age_us = static_cast<double>(now_us - edge.t_us);
  const Eigen::Vector2d image = camera_flow_px_s(edge);
  if (image.norm() > camera_moves_px_s) return at + image * (age_us * 1e-6);
  return at + edge.gradient_us_px * (age_us / edge.gradient_us_px.squaredNorm());
}

/// Calls f(offset from the centre, distance off the outline, moves along the normal) for every edge near a
/// circle.
template <class Function>
void BallTracker::for_each_on(const Circle& c, double off_px, std::int64_t now_us, Function f) const {
  const double reach_px = c.r_px + 2.0 * config_.crossing_px;  // an edge is kept where it came
  edges_.for_each_near(c.x_px, c.y_px, reach_px, now_us, [&](const Edge& edge) {
    const Eigen::Vector2d offset = now_at(edge, now_us) - Eigen::Vector2d(c.x_px, c.y_px);
    const double distance = offset.norm();
    if (distance - c.r_px > off_px) return;
    const bool aligned = std::abs(edge.gradient_us_px.dot(offset)) >=
                         CircleTrack::min_alignment * edge.gradient_us_px.norm() * distance;
    f(offset, distance - c.r_px, aligned);
  });
}

BallTracker::Outline BallTracker::outline(const Circle& c, std::int64_t now_us) const {
  constexpr double pi = std::numbers::pi;
  const double length_px = 2.0 * pi * c.r_px;
  const int sectors = std::clamp(static_cast<int>(length_px / sector_px), min_sectors, max_sectors);
  std::uint32_t seen = 0;
  double on = 0.0, aligned_on = 0.0, inside = 0.0, around = 0.0;
  for_each_on(c, outer_end_px, now_us, [&](const Eigen::Vector2d& offset, double off_px, bool aligned) {
    if (off_px > outer_begin_px && aligned) around += 1.0;
    if (off_px < -inner_px) inside += 1.0;
    if (std::abs(off_px) > outline_px) return;
    on += 1.0;
    if (!aligned) return;
    aligned_on += 1.0;
    const double turn = (std::atan2(offset.y(), offset.x()) + pi) / (2.0 * pi);
    seen |= 1u << std::min(static_cast<int>(turn * sectors), sectors - 1);
  });
  if (aligned_on == 0.0) return {};
  const double inner_r_px = std::max(c.r_px - inner_px, 1.0);
  const double on_per_px2 = aligned_on / (length_px * 2.0 * outline_px);
  const double ring_px2 =
      pi * (outer_end_px - outer_begin_px) * (2.0 * c.r_px + outer_end_px + outer_begin_px);
  const double around_per_px2 = around / ring_px2;
  Outline o;
  o.quality = static_cast<double>(std::popcount(seen)) / sectors * aligned_on / on *
              std::exp(-inner_penalty_px2 * inside / (pi * inner_r_px * inner_r_px));
  o.activity = on / length_px;
  o.calm = std::exp(-around_per_px2 / clutter_per_px2);
  o.clarity = std::max(0.0, 1.0 - around_per_px2 / on_per_px2) * o.calm;
  return o;
}

/// Weighted least squares on the edges near a circle.
Circle BallTracker::fit(Circle c, std::int64_t now_us) const {
  constexpr double near_px = 3.0;
  for (int pass = 0; pass < 3; ++pass) {
    Eigen::Matrix3d normal = 0.5 * Eigen::Matrix3d::Identity();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    int used = 0;
    for_each_on(c, near_px, now_us, [&](const Eigen::Vector2d& offset, double off_px, bool aligned) {
      const double distance = offset.norm();
      if (off_px < -near_px || !aligned || distance < 1.0) return;
      const double share = off_px / near_px;
      const double weight = (1.0 - share * share) * (1.0 - share * share);
      const Eigen::Vector3d gradient(offset.x() / distance, offset.y() / distance, 1.0);
      normal += weight * gradient * gradient.transpose();
      right += weight * off_px * gradient;
      ++used;
    });
    if (used < 5) return c;
    const Eigen::Vector3d step = ldlt_solution(normal, right);
    c.x_px += std::clamp(step[0], -1.5, 1.5);
    c.y_px += std::clamp(step[1], -1.5, 1.5);
    c.r_px = std::clamp(c.r_px + std::clamp(step[2], -1.0, 1.0), config_.radius_px[0] - 0.5,
                        config_.radius_px[1] + 0.5);
  }
  return c;
}

bool BallTracker::continues_burst(const Event& event) {
  const int pixel = event.y * camera_.size.width + event.x;
  std::int64_t& last_us = last_event_us_[static_cast<std::size_t>(2 * pixel + (event.on ? 1 : 0))];
  const bool continues = last_us != never_us && saturated_difference(event.t_us, last_us) < config_.burst_us;
  last_us = event.t_us;
  return continues;
}

void BallTracker::process(std::span<const Event> events, const CameraMotion* motion) {
  know(motion);
  for (const Event& event : events) {
    if (!sieve_.accept(event)) continue;
    run_until(event.t_us, false);
    if (continues_burst(event)) continue;
    for (Followed& f : followed_) {
      if (!f.alive) continue;
      const Eigen::Vector2d at(event.x, event.y);
      if ((at - f.track.centre()).norm() - f.track.circle().r_px > near_px) continue;
      f.track.predict(event.t_us, camera_flow_px_s(f.track.centre()));
      f.silhouette.add(at, f.track.carried_px(), event.t_us);
    }
    flow_.add(event);
    const auto flow = flow_.at(event);
    if (!flow) continue;
    const Eigen::Vector2d gradient(flow->dt_dx_us_px, flow->dt_dy_us_px);
    const double slowness = gradient.norm();
    if (slowness < fastest_us_px) continue;
    const double life_us = std::clamp(config_.crossing_px * slowness, shortest_life_us,
                                      std::max(shortest_life_us, static_cast<double>(config_.longest_us)));
    const Edge edge{
        event.t_us, saturated_sum(event.t_us, static_cast<std::int64_t>(life_us)),
        gradient,   event.x,
        event.y,    static_cast<std::int16_t>(HoughTransform::direction_of(gradient.x(), gradient.y()))};
    edges_.add(edge);
    for (Followed& f : followed_) {
      if (!f.alive) continue;
      const Circle c = f.track.circle();
      if (std::abs(std::hypot(edge.x - c.x_px, edge.y - c.y_px) - c.r_px) > near_px) continue;
      f.track.measure(edge, f.clarity, CircleTrack::Learn::place, camera_flow_px_s(f.track.centre()));
    }
  }
}

void BallTracker::advance_to(std::int64_t now_us, const CameraMotion* motion) {
  know(motion);
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
    const bool idle = best() == nullptr && edges_.last_end_us() < *next_tick_us_;
    if (idle && candidates_.empty()) {
      next_tick_us_ = first_tick();
      return;
    }
    tick(*next_tick_us_);
    *next_tick_us_ = saturated_sum(*next_tick_us_, tick_us);
  }
}

void BallTracker::tick(std::int64_t now_us) {
  bool following = false;
  for (Followed& f : followed_) {
    if (!f.alive) continue;
    f.anchor_px += camera_flow_px_s(f.anchor_px) * tick_s;
    f.track.predict(now_us, camera_flow_px_s(f.track.centre()));
    f.anchor_px += (f.track.centre() - f.anchor_px) * (tick_s / anchor_s);
    const bool follows = f.hole > following_hole;
    const Eigen::Vector2d image = follows ? camera_flow_px_s(f.track.centre()) : Eigen::Vector2d::Zero();
    if (f.track.rest_if_silent(image)) f.score *= silence_share;
    f.track.bound(config_.radius_px[0], config_.radius_px[1]);
    f.worth = worth_of(f.score, f.moved_px());
    const Eigen::Vector2d at = f.track.centre();
    const bool inside =
        at.x() >= 0.0 && at.y() >= 0.0 && at.x() < camera_.size.width && at.y() < camera_.size.height;
    f.alive = inside && static_cast<double>(f.track.silent_us()) <= config_.hold_s * 1e6;
    following = following || (f.alive && f.score > following_score);
  }
  const std::int64_t since_us =
      last_look_us_ == never_us ? latest_us : saturated_difference(now_us, last_look_us_);
  if (since_us < (following ? look_following_us : look_searching_us)) return;
  last_look_us_ = now_us;
  find_candidates(now_us);
  score_tracks(now_us, static_cast<double>(std::min(since_us, look_following_us)) * 1e-6);
  take_candidates(now_us);
}

/// The strongest circles of the Hough space, each with what it explains taken out before the next.
void BallTracker::find_candidates(std::int64_t now_us) {
  transform_.clear();
  votes_.clear();
  candidates_.clear();
  edges_.for_each(now_us, [&](const Edge& edge) {
    const Eigen::Vector2d at = now_at(edge, now_us);
    if (!(at.x() > -0.5 && at.y() > -0.5 && at.x() < camera_.size.width - 0.5 &&
          at.y() < camera_.size.height - 0.5))
      return;
    votes_.push_back({static_cast<std::uint16_t>(std::lround(at.x())),
                      static_cast<std::uint16_t>(std::lround(at.y())), edge.direction, false});
    transform_.vote_arcs<1>(votes_.back().x, votes_.back().y, edge.direction);
  });
  while (candidates_.size() < max_candidates) {
    const HoughTransform::Peak peak = transform_.peak();
    if (peak.votes < 3) break;
    const Circle raw{static_cast<double>(peak.x), static_cast<double>(peak.y), static_cast<double>(peak.r)};
    const Circle circle = fit(raw, now_us);
    const Outline o = outline(circle, now_us);
    candidates_.push_back({circle, o.quality * o.calm, o.clarity});
    for (Vote& vote : votes_) {
      const double distance = std::hypot(vote.x - raw.x_px, vote.y - raw.y_px);
      if (vote.explained || std::abs(distance - raw.r_px) > outline_px) continue;
      vote.explained = true;
      transform_.vote_arcs<-1>(vote.x, vote.y, vote.direction);
    }
  }
}

void BallTracker::score_tracks(std::int64_t now_us, double dt_s) {
  for (Followed& f : followed_) {
    if (!f.alive) continue;
    const Outline o = outline(f.track.circle(), now_us);
    f.clarity = o.clarity;
    f.hole = 0.0;
    if (const auto hole = f.silhouette.fit(f.track.circle(), f.track.carried_px(), now_us)) {
      const double speed = (f.track.speed_px_s() + camera_flow_px_s(f.track.centre())).norm();
      const double slow = 1.0 / (1.0 + speed * speed / (hole_slow_px_s * hole_slow_px_s));
      f.track.correct(hole->circle, hole->sd_px.cwiseMax(hole_least_sd_px) / slow);
      const double shown = hole->seen * hole->emptiness * hole->emptiness;
      f.hole = shown * shown * hole->tightness * slow * moved_share(f.moved_px());
    }
    const double quality = std::max(o.quality, f.hole);
    const double time_s = quality > f.score ? rise_s : quality > lost_quality ? fall_s : lost_s;
    const double evidence =
        f.hole > o.quality ? 1.0 : std::min(1.0, o.activity / full_activity_per_px) * o.calm;
    f.score += (quality - f.score) * (1.0 - std::exp(-dt_s * (evidence / time_s + 1.0 / forget_s)));
  }
}

void BallTracker::take_candidates(std::int64_t now_us) {
  for (const Candidate& candidate : candidates_) {
    bool known = false;
    for (Followed& f : followed_) {
      if (!f.alive) continue;
      const Circle circle = f.track.circle();
      if (is_same(circle, candidate.circle, 6.0, 4.0) && candidate.clarity >= fit_clarity) {
        const Outline o = outline(circle, now_us);
        if (candidate.quality > o.quality * o.calm + better_by) {
          f.track.doubt();
          f.track.correct(candidate.circle, Eigen::Vector3d::Constant(fit_sd_px));
          known = true;
          break;
        }
      }
      known = known || is_same(circle, candidate.circle, 4.0, 2.0);
    }
    if (known || candidate.quality < birth_quality) continue;
    Followed* weakest = &followed_[0];
    for (Followed& f : followed_) {
      if (!weakest->alive) break;
      if (!f.alive || f.worth < weakest->worth) weakest = &f;
    }
    const double score = birth_share * candidate.quality;
    if (weakest->alive && worth_of(score, 0.0) <= weakest->worth) continue;
    weakest->alive = true;
    weakest->track = CircleTrack(candidate.circle, now_us);
    weakest->silhouette.clear();
    weakest->score = score;
    weakest->worth = worth_of(score, 0.0);
    weakest->clarity = 1.0;
    weakest->hole = 0.0;
    weakest->anchor_px = {candidate.circle.x_px, candidate.circle.y_px};
    const Eigen::Vector2d image = camera_flow_px_s(weakest->anchor_px);
    // Its speed comes from the flow of the edges that are there.
    edges_.for_each_near(candidate.circle.x_px, candidate.circle.y_px,
                         candidate.circle.r_px + 2.0 * config_.crossing_px, now_us, [&](const Edge& edge) {
                           weakest->track.measure(edge, 1.0, CircleTrack::Learn::place_and_speed, image);
                         });
    weakest->track.place(candidate.circle);
  }
  for (Followed& a : followed_) {  // of two that have become one the weaker ends
    for (Followed& b : followed_) {
      if (&a == &b || !a.alive || !b.alive || a.worth < b.worth) continue;
      if (is_same(a.track.circle(), b.track.circle(), 2.0, 1.5)) b.alive = false;
    }
  }
}

double BallTracker::worth_of(double score, double moved_px) const {
  if (!rotation_rad_s_) return score;
  return score * (in_the_room_share + (1.0 - in_the_room_share) * moved_share(moved_px));
}

const BallTracker::Followed* BallTracker::best() const {
  const Followed* best = nullptr;
  for (const Followed& f : followed_) {
    if (f.alive && (best == nullptr || f.worth > best->worth)) best = &f;
  }
  return best;
}

Estimate BallTracker::estimate() {
  if (const Followed* f = best()) {
    const Circle circle = f->track.circle_at(now_us_, camera_flow_px_s(f->track.centre()));
    return {true, f->track.silent_us() >= tick_us, circle, f->worth};
  }
  if (candidates_.empty()) return {};
  return {true, false, candidates_[0].circle, candidate_share * candidates_[0].quality};
}

bool BallTracker::hough_space(std::span<float> response) const {
  HoughTransform whole = transform_;  // which lacks what the last look has explained
  for (const Vote& vote : votes_) {
    if (vote.explained) whole.vote_arcs<1>(vote.x, vote.y, vote.direction);
  }
  largest_response(whole, response);
  return true;
}

}  // namespace saccade
