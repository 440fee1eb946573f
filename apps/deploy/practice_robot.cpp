#include "apps/deploy/practice_robot.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "control/head_kinematics.h"
#include "core/random.h"
#include "core/units.h"

namespace saccade {
namespace {

constexpr double ball_radius_m = 0.0475;
constexpr double ball_height_m = 0.33;  // of the eyes
constexpr std::int64_t image_us = 1'000;
constexpr std::int64_t longest_gap_us = 20'000;  // images of a longer pause are not made up for

}  // namespace

void describe(FieldVisitor& v, PracticeConfig& config) {
  v.text("head", config.head, "name of the head in shared memory; programs with the same name share it");
  v.real("ball_distance_m", config.ball_distance_m, {0.25, 1.0}, "distance of the ball in front of the root");
  v.real("circle_radius_m", config.circle_radius_m, {0.0, 0.2},
         "radius of the circle on which the ball moves");
  v.real("circle_period_s", config.circle_period_s, {0.5, 60.0}, "duration of a turn of the ball");
  v.real("noise_hz", config.noise_hz, {0.0, 10.0}, "noise events per pixel and second");
  v.real("end_s", config.end_s, {0.0, 1e6}, "time after which the robot ends; 0: never");
}

std::string head_name(const PracticeConfig& config) { return "practice/" + config.head; }

PortStatus PracticeRobot::RealClock::wait_until(std::int64_t t_us) {
  if (is_over()) return PortStatus::ended;
  return steady_.wait_until(t_us);
}

PracticeRobot::PracticeRobot(const PracticeConfig& config, const RobotContext& context)
    : config_(check_config("practice", config)),
      limits_(context.limits),
      clock_(config.end_s),
      start_ns_(machine_ns() - 1000 * clock_.now_us()),
      head_(config.head) {
  if (context.image_size != camera_.size)
    throw InputError("calibration", in_words(context.image_size), in_words(camera_.size));
  disc_ = look(0);
}

std::vector<StartUpCheck> PracticeRobot::check() {
  return {{"practice head " + config_.head, true, "in shared memory, 6 joints"}};
}

void PracticeRobot::activate() { taken_ = head_.take(); }

void PracticeRobot::release() {
  if (taken_.exchange(0) != 0 && head_.follows()) head_.hold();
}

void PracticeRobot::halt() {
  if (taken_ != 0) head_.hold();
}

bool PracticeRobot::Disc::covers(int x, int y) const {
  const double dx = x - x_px;
  const double dy = y - y_px;
  return dx * dx + dy * dy <= r_px * r_px;
}

PracticeRobot::Disc PracticeRobot::look(std::int64_t t_us) const {
  const double turn_rad = 2e-6 * std::numbers::pi * static_cast<double>(t_us) / config_.circle_period_s;
  const Eigen::Vector3d ball_m(-config_.ball_distance_m, config_.circle_radius_m * std::cos(turn_rad),
                               ball_height_m + config_.circle_radius_m * std::sin(turn_rad));
  const HeadState state = head_.state(start_ns_ + 1000 * t_us);
  const auto circle = camera_.project_sphere(
      HeadKinematics(limits_.head->chain, state.position_rad).root_from_eye(Eye::left).inverse() * ball_m,
      ball_radius_m);
  return circle ? Disc{circle->x_px, circle->y_px, circle->r_px} : Disc{};
}

/// The events of the millisecond that ends at t_us.
void PracticeRobot::draw(std::int64_t t_us, std::vector<Event>& events) {
  const Disc before = disc_;
  disc_ = look(t_us);
  const auto first = [](double a, double b) {
    return std::max(0, static_cast<int>(std::floor(std::min(a, b))));
  };
  const auto last = [](double a, double b, int size) {
    return std::min(size - 1, static_cast<int>(std::ceil(std::max(a, b))));
  };
  const int last_x = last(before.x_px + before.r_px, disc_.x_px + disc_.r_px, camera_.size.width);
  const int last_y = last(before.y_px + before.r_px, disc_.y_px + disc_.r_px, camera_.size.height);
  for (int y = first(before.y_px - before.r_px, disc_.y_px - disc_.r_px); y <= last_y; ++y) {
    for (int x = first(before.x_px - before.r_px, disc_.x_px - disc_.r_px); x <= last_x; ++x) {
      const bool is_in = disc_.covers(x, y);
      if (is_in == before.covers(x, y)) continue;
      events.push_back({t_us, static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y), is_in, 0});
    }
  }
  const RandomStream random(1, "practice noise");
  const auto number = static_cast<std::uint64_t>(t_us);
  const double expected = config_.noise_hz * 1e-3 * camera_.size.width * camera_.size.height;
  const int count = static_cast<int>(expected + random.uniform(0.0, 1.0, 0, number));
  for (int i = 0; i < count; ++i) {
    const std::uint64_t bits = random.bits(1 + static_cast<std::uint64_t>(i), number);
    events.push_back(
        {t_us, static_cast<std::uint16_t>(bits % static_cast<std::uint64_t>(camera_.size.width)),
         static_cast<std::uint16_t>((bits >> 20) % static_cast<std::uint64_t>(camera_.size.height)),
         ((bits >> 50) & 1) != 0, 0});
  }
}

PortStatus PracticeRobot::read_until(std::int64_t t_us, std::vector<Event>& events) {
  if (t_us - drawn_us_ > longest_gap_us) drawn_us_ = (t_us - longest_gap_us) / image_us * image_us;
  while (drawn_us_ + image_us <= t_us) draw(drawn_us_ += image_us, events);
  return clock_.is_over() ? PortStatus::ended : PortStatus::ok;
}

PortStatus PracticeRobot::read(HeadState& state) {
  const std::int64_t now_us = clock_.now_us();
  state = head_.state(start_ns_ + 1000 * now_us);
  state.t_us = now_us;
  return PortStatus::ok;
}

HeadDrives PracticeRobot::drives() const {
  return HeadDrives::all(taken_ != 0 && head_.follows() ? JointDrive::references : JointDrive::held);
}

HeadPort::CommandResult PracticeRobot::command(const HeadCommand& reference_rad) {
  const bool accepted = is_allowed(reference_rad, limits_) && head_.command(taken_, reference_rad);
  return {PortStatus::ok, !accepted};
}

PortStatus PracticeRobot::stop() {
  HeadState state;
  read(state);
  const HeadCommand reference_rad = state.head_position_rad()
                                        .cwiseMax(limits_.min_rad.tail<gaze_slots>())
                                        .cwiseMin(limits_.max_rad.tail<gaze_slots>());
  (void)head_.command(taken_, reference_rad);
  return PortStatus::ok;
}

bool PracticeStopper::stop() {
  if (head_.follows()) head_.hold();
  return true;
}

}  // namespace saccade
