#include "sim/image_sampler.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>
#include <tuple>

#include "core/units.h"
#include "head/icub_cameras.h"
#include "sim/sim_robot.h"

namespace saccade {
namespace {

WorldConfig moving_ball() {
  WorldConfig config;
  config.ball.trajectory.kind = TrajectoryKind::circle;
  config.ball.trajectory.frequency_hz = 0.8;
  return config;
}

/// Eyes that turn by `angle_deg` and back repeatedly, with a minimum-jerk move of `move_s` each way.
HeadJointVector saccades(std::int64_t t_us, double angle_deg, double move_s) {
  const double phase = static_cast<double>(t_us) * 1e-6 / move_s;
  const double s = phase - std::floor(phase);
  const double moved = s * s * s * (10.0 - 15.0 * s + 6.0 * s * s);
  const bool back = static_cast<std::int64_t>(phase) % 2 == 1;
  HeadJointVector reference_rad = HeadJointVector::Zero();
  reference_rad[eyes_version - torso_joint_count] = angle_deg * rad_per_deg * (back ? 1.0 - moved : moved);
  return reference_rad;
}

/// The times of all images while the eyes make saccades, and the world at each.
template <class Look>
void sample(const SamplingConfig& config, World& world, std::int64_t until_us, bool saccading, Look look) {
  const MjDataPtr shown(mj_makeData(&world.model()));
  ImageSampler sampler(config, ImageMotion(world.model(), world.left_eye_camera(), icub_left_2016));
  const auto show = [&](std::int64_t t_us) -> const mjData& {
    world.show(t_us, *shown);
    return *shown;
  };
  sampler.take(0, world.data());
  look(std::int64_t{0}, world.data());
  while (world.now_us() < until_us) {
    const std::int64_t begin_us = world.now_us();
    if (saccading) world.set_reference(saccades(begin_us, 12.0, 0.08));
    world.step();
    while (const auto t_us = sampler.next(begin_us, world.now_us(), show)) {
      const mjData& data = show(*t_us);
      sampler.take(*t_us, data);
      look(*t_us, data);
    }
  }
}

TEST(ImageSampler, DrawsAtTheLongestIntervalWhereNothingMoves) {
  WorldConfig still;
  still.ball.trajectory.sway_m = 0.0;
  World world(still, "", 1);
  std::vector<std::int64_t> times_us;
  sample({}, world, 200'000, false, [&](std::int64_t t_us, const mjData&) { times_us.push_back(t_us); });
  ASSERT_EQ(times_us.size(), 41U);
  for (std::size_t i = 0; i < times_us.size(); ++i) {
    EXPECT_EQ(times_us[i], 5000 * static_cast<std::int64_t>(i));
  }
}

TEST(ImageSampler, DrawsTenThousandImagesPerSecondIfConfigured) {
  World world(moving_ball(), "", 1);
  std::int64_t due_us = 0;
  sample({10.0, 0.1}, world, 20'000, true, [&](std::int64_t t_us, const mjData&) {
    EXPECT_EQ(t_us, due_us);
    due_us += 100;
  });
  EXPECT_EQ(due_us, 20'100);
}

TEST(ImageSampler, DrawsAtTheEndOfEveryTickIfTheLongestIntervalIsAMillisecond) {
  World world(moving_ball(), "", 1);
  std::int64_t ends = 0;
  std::int64_t all = 0;
  sample({0.5, 1.0}, world, 150'000, true, [&](std::int64_t t_us, const mjData&) {
    ends += t_us % World::tick_us == 0 ? 1 : 0;
    ++all;
  });
  EXPECT_EQ(ends, 151);
  EXPECT_GT(all, 160);
}

TEST(ImageSampler, ImagesThatAreHeldBackComeAtThatIntervalAndAfterwardsAsConfigured) {
  World world(moving_ball(), "", 1);
  const MjDataPtr shown(mj_makeData(&world.model()));
  ImageSampler sampler({0.25, 5.0, 1.0}, ImageMotion(world.model(), world.left_eye_camera(), icub_left_2016));
  const auto show = [&](std::int64_t t_us) -> const mjData& {
    EXPECT_TRUE(t_us > world.now_us() - World::tick_us - 1 && t_us <= world.now_us()) << t_us;
    world.show(t_us, *shown);
    return *shown;
  };
  std::vector<std::int64_t> times_us{0};
  sampler.take(0, world.data());
  while (world.now_us() < 160'000) {
    const std::int64_t begin_us = world.now_us();
    if (begin_us == 40'000) sampler.hold_back(8'000);
    if (begin_us == 115'000) sampler.hold_back(0);
    world.set_reference(saccades(begin_us, 12.0, 0.08));
    world.step();
    while (const auto t_us = sampler.next(begin_us, world.now_us(), show)) {
      sampler.take(*t_us, show(*t_us));
      times_us.push_back(*t_us);
    }
  }
  std::int64_t held = 0, fast = 0;
  for (std::size_t i = 1; i < times_us.size(); ++i) {
    const std::int64_t interval_us = times_us[i] - times_us[i - 1];
    EXPECT_GE(interval_us, 1'000);
    EXPECT_LE(interval_us, 8'000 + World::tick_us);
    const bool is_held = times_us[i] > 40'000 && times_us[i] < 115'000;
    EXPECT_TRUE(!is_held || interval_us >= 8'000) << times_us[i];
    held += is_held ? 1 : 0;
    fast += interval_us < 2'000 ? 1 : 0;
  }
  EXPECT_GE(held, 8);
  EXPECT_GT(fast, 20) << "before and after, in a saccade";
}

/// Points in the image whose motion must stay below the bound: a fine grid of the room at several depths, and points
/// on the whole surface of the ball.
class Witnesses {
 public:
  explicit Witnesses(const World& world) : world_(world) {
    for (int i = 0; i < 400; ++i) {  // evenly over a sphere
      const double z = 1.0 - (i + 0.5) / 200.0;
      const double turn = std::numbers::pi * (1.0 + std::sqrt(5.0)) * i;
      const double around = std::sqrt(1.0 - z * z);
      sphere_.push_back(*world.target_radius_m() *
                        Eigen::Vector3d(around * std::cos(turn), around * std::sin(turn), z));
    }
  }
  /// The largest displacement since the last call.
  double moved_px(const mjData& data) {
    const Eigen::Isometry3d root_from_cam = World::root_from_camera(data, world_.left_eye_camera());
    const Eigen::Isometry3d cam_from_root = root_from_cam.inverse();
    double largest = 0.0;
    const auto see = [&](const Eigen::Vector3d& point_m, const Eigen::Vector2d& before_px) {
      const auto now_px = camera_.project(cam_from_root * point_m);
      if (now_px) largest = std::max(largest, (*now_px - before_px).norm());
    };
    for (const auto& [point_m, before_px] : room_) see(point_m, before_px);
    const Eigen::Vector3d ball_m = world_.target_position_m(data);
    for (std::size_t i = 0; i < ball_px_.size(); ++i) see(ball_m + sphere_[i], ball_px_[i]);

    room_.clear();
    ball_px_.clear();
    for (double y = 0.0; y < camera_.size.height; y += 9.0) {
      for (double x = 0.0; x < camera_.size.width; x += 9.0) {
        for (const double depth_m : {0.7, 1.5, 3.0}) {
          room_.emplace_back(root_from_cam * (depth_m * camera_.ray(x, y)), Eigen::Vector2d(x, y));
        }
      }
    }
    for (const Eigen::Vector3d& offset_m : sphere_) {
      ball_px_.push_back(*camera_.project(cam_from_root * (ball_m + offset_m)));
    }
    return largest;
  }

 private:
  const World& world_;
  Camera camera_ = icub_left_2016;
  std::vector<Eigen::Vector3d> sphere_;
  std::vector<std::pair<Eigen::Vector3d, Eigen::Vector2d>> room_;
  std::vector<Eigen::Vector2d> ball_px_;
};

TEST(ImageSampler, KeepsMotionBelowItsBoundAndImagesYoungerThanFiveMilliseconds) {
  for (const double bound_px : {0.25, 0.5, 1.0}) {
    World world(moving_ball(), "", 1);
    Witnesses witnesses(world);
    double farthest_px = 0.0;
    double sum_px = 0.0;
    std::int64_t oldest_us = 0;
    std::int64_t last_us = 0;
    int images = 0;
    sample({bound_px, 5.0}, world, 400'000, true, [&](std::int64_t t_us, const mjData& data) {
      const double moved_px = witnesses.moved_px(data);
      farthest_px = std::max(farthest_px, moved_px);
      sum_px += moved_px;
      oldest_us = std::max(oldest_us, t_us - last_us);
      last_us = t_us;
      ++images;
    });
    std::printf("bound %.2f px: %d images, at most %.3f px and %.1f ms apart, %.3f px on average\n", bound_px,
                images, farthest_px, static_cast<double>(oldest_us) * 1e-3, sum_px / images);
    EXPECT_LE(farthest_px, bound_px);
    EXPECT_GT(sum_px / images, 0.75 * bound_px);  // not more images than necessary
    EXPECT_LE(oldest_us, 5000);
  }
}

/// The result of one sampling of a motion, to compare with that of another one.
struct Recording {
  std::vector<Event> events;
  std::vector<Eigen::Isometry3d> root_from_cam;  // at every tick
  std::int64_t images = 0;
};

constexpr std::int64_t saccade_us = 70'000;
constexpr std::int64_t seen_us = 85'000;  // from its start until the eye rests

Recording record_saccade(const SimConfig& config, const SamplingConfig& sampling) {
  const Lab lab(config.lab, 1);
  World world(config.world, lab.mjcf(), 1);
  const auto gl = GlContext::create(config.gl);
  lab.paint(world.model());
  EyeRenderer eye(world.model(), *gl, config.camera, config.render);
  EventEmulator emulator(config.emulator, config.camera.size, 1);
  ImageSampler sampler(sampling, ImageMotion(world.model(), world.left_eye_camera(), config.camera));
  std::vector<float> luminance(static_cast<std::size_t>(config.camera.size.pixels()));
  const MjDataPtr shown(mj_makeData(&world.model()));
  Recording recording;
  const auto show = [&](std::int64_t t_us) -> const mjData& {
    world.show(t_us, *shown);
    return *shown;
  };
  const auto take = [&](std::int64_t t_us) {
    sampler.take(t_us, show(t_us));
    eye.render(*shown, world.left_eye_camera(), luminance);
    emulator.process_image(luminance, t_us, recording.events);
    ++recording.images;
  };
  recording.root_from_cam.push_back(world.root_from_left_cam());
  sampler.take(0, world.data());
  eye.render(world.data(), world.left_eye_camera(), luminance);
  emulator.process_image(luminance, 0, recording.events);
  recording.images = 1;
  while (world.now_us() < seen_us) {
    const std::int64_t begin_us = world.now_us();
    world.set_reference(saccades(std::min(begin_us, saccade_us - 1), 11.6, 1e-6 * saccade_us));
    world.step();
    recording.root_from_cam.push_back(world.root_from_left_cam());
    while (const auto t_us = sampler.next(begin_us, world.now_us(), show)) take(*t_us);
  }
  return recording;
}

/// Angular velocity of the eye in the tick of an event, rad/s, camera frame.
Eigen::Vector3d turning_rad_s(const Recording& recording, std::int64_t t_us) {
  const auto tick = static_cast<std::size_t>((t_us - 1) / World::tick_us);
  const Eigen::AngleAxisd turn(recording.root_from_cam[tick].linear().transpose() *
                               recording.root_from_cam[tick + 1].linear());
  return turn.axis() * turn.angle() / 1e-3;
}

/// |dt| of events of one pixel and polarity, in their order, times the speed of the image there.
std::vector<double> distances_px(const Recording& fixed, const Recording& adaptive, const Camera& camera) {
  std::map<std::tuple<int, int, bool>, std::vector<std::int64_t>> times_us;
  for (const Event& e : adaptive.events) times_us[{e.x, e.y, e.on}].push_back(e.t_us);
  std::map<std::tuple<int, int, bool>, std::size_t> next;
  std::vector<double> distances;
  for (const Event& e : fixed.events) {
    const std::tuple<int, int, bool> pixel{e.x, e.y, e.on};
    const auto& times = times_us[pixel];
    const std::size_t i = next[pixel]++;
    if (i >= times.size()) continue;
    const double speed_px_s =
        camera.rotational_flow_px_s(camera.ray(e.x, e.y), turning_rad_s(fixed, e.t_us)).norm();
    distances.push_back(static_cast<double>(std::abs(times[i] - e.t_us)) * 1e-6 * speed_px_s);
  }
  return distances;
}

/// Detail of the lab that is finer than a sample flickers from image to image and clips where it passes between
/// two images: the more samples, the nearer are the counts.
struct Condition {
  Clutter clutter;
  std::string preset;
  std::int64_t supersampling;
  double max_displacement_px;
  double count_tolerance;
};

void PrintTo(const Condition& c, std::ostream* out) {
  *out << word_of(c.clutter) << ", " << c.preset << ", " << c.supersampling << " samples, "
       << c.max_displacement_px << " px";
}

class AdaptiveSampling : public testing::TestWithParam<Condition> {};
INSTANTIATE_TEST_SUITE_P(Lab, AdaptiveSampling,
                         testing::Values(Condition{Clutter::textured, "dvs128", 4, 0.3, 0.01},
                                         Condition{Clutter::rectilinear, "dvs128", 2, 0.5, 0.05},
                                         Condition{Clutter::textured, "ideal", 2, 0.5, 0.05}),
                         [](const auto& test) {
                           return std::string(word_of(test.param.clutter)) + "_" + test.param.preset + "_" +
                                  std::to_string(test.param.supersampling) + "_samples";
                         });

TEST_P(AdaptiveSampling, ASaccadeOf300DegreesPerSecondGivesTheEventsOfTenThousandImagesPerSecond) {
  SimConfig config;
  config.lab.clutter = GetParam().clutter;
  config.camera.size.height = 36;  // the middle of the image
  config.camera.cy_px -= 46.0;
  config.render.supersampling = GetParam().supersampling;
  config.emulator = emulator_preset(GetParam().preset);
  config.emulator.leak_rate_hz = config.emulator.shot_noise_rate_hz = 0.0;
  config.emulator.readout_rate_hz = 0.0;  // a full bus would delay all events
  const Recording fixed = record_saccade(config, {10.0, 0.1});
  const Recording adaptive = record_saccade(config, {GetParam().max_displacement_px, 5.0});

  double fastest_deg_s = 0.0;
  for (std::int64_t t_us = 1; t_us <= seen_us; t_us += World::tick_us) {
    fastest_deg_s = std::max(fastest_deg_s, turning_rad_s(fixed, t_us).norm() / rad_per_deg);
  }
  std::vector<double> off_px = distances_px(fixed, adaptive, config.camera);
  ASSERT_GT(off_px.size(), 1000U);
  const auto middle = off_px.begin() + static_cast<std::ptrdiff_t>(off_px.size() / 2);
  std::nth_element(off_px.begin(), middle, off_px.end());
  const double more =
      static_cast<double>(adaptive.events.size()) / static_cast<double>(fixed.events.size()) - 1.0;
  const double fewer = static_cast<double>(fixed.images) / static_cast<double>(adaptive.images);
  std::printf(
      "%.0f deg/s: %zu and %zu events (%+.2f %%), median |dt| times image speed %.3f px, %.1f times fewer "
      "images\n",
      fastest_deg_s, fixed.events.size(), adaptive.events.size(), 100.0 * more, *middle, fewer);
  EXPECT_GT(fastest_deg_s, 295.0);
  EXPECT_NEAR(more, 0.0, GetParam().count_tolerance);
  EXPECT_LE(*middle, 0.1);
  EXPECT_GE(fewer, 5.0);
}

}  // namespace
}  // namespace saccade
