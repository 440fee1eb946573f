#pragma once

#include <Eigen/Geometry>
#include <cmath>

#include "sim/random_generator.h"
#include "worlds/random_world.h"

// The draws of a random world, part by part.
namespace saccade::random_world {

/// draw_world() for the head of a scenario, through whose left eye the world is seen. A head without the iCub's joints of neck
/// and eyes does not move.
[[nodiscard]] DrawnWorld draw_world(const RandomWorldConfig& config, std::uint64_t seed,
                                    const std::optional<Camera>& camera, const HeadConfig& head);

/// Uniform in the logarithm.
inline double log_real(RandomGenerator& random, double low, double high) {
  return low * std::pow(high / low, random.real(0.0, 1.0));
}
/// One of the values.
template <class Value, std::size_t N>
Value one_of(RandomGenerator& random, const Value (&values)[N]) {
  return values[random.index(static_cast<int>(N))];
}

/// The space in front of the left eye, in which things are placed by where they are seen.
struct Stage {
  Camera camera;                    ///< without its lens: there are points outside the image too
  Eigen::Isometry3d root_from_eye;  ///< the mean pose of the camera
  double farthest_m;                ///< along the optical axis: nearer than the furniture

  /// The point at depth z_m whose place in the image is (u, v): 0 at the left and top border, 1 at the others.
  [[nodiscard]] Eigen::Vector3d point(double u, double v, double z_m) const;
  /// A point inside the image, at a depth from near_m to far_m.
  [[nodiscard]] Eigen::Vector3d any_point(RandomGenerator& random, double near_m, double far_m) const;
  /// Metres per pixel at a depth.
  [[nodiscard]] double metres_per_px(double z_m) const { return z_m / camera.fx_px; }
};

/// A camera: image size, field of view, principal point.
[[nodiscard]] Camera draw_camera(RandomGenerator& random);
/// Events per second that the bus of a sensor with this preset and image transmits: the preset's rate, and in images above
/// 128x128 at least that of a sensor of this size, 1 Mevent/s (number of pixels / 128^2)^1.459. The power law passes through
/// DVS128 (1 Mevent/s at 128x128) and DAVIS346 (12 Mevent/s at 346x260). 0: no limit.
[[nodiscard]] double bus_rate_hz(const EmulatorConfig& preset, ImageSize size);
/// A sensor: one of the presets of the event camera.
[[nodiscard]] EmulatorConfig draw_sensor(RandomGenerator& random);
/// A room with its light and the round things in it.
[[nodiscard]] LabConfig draw_lab(RandomGenerator& random);

/// Which of eyes and neck move, and where to. `alone`: nothing else moves, so that pauses are short.
[[nodiscard]] HeadMotion draw_motion(RandomGenerator& random);
[[nodiscard]] ScriptConfig draw_script(RandomGenerator& random, HeadMotion motion, bool alone);

/// Objects that move by themselves and are no ball, `count` of them; the first is in the image from the start.
[[nodiscard]] NamedObjects draw_distractors(RandomGenerator& random, const Stage& stage, int count);
/// A board that passes before the ball at about `ball_m`.
[[nodiscard]] ObjectConfig draw_board(RandomGenerator& random, const Stage& stage,
                                      const Eigen::Vector3d& ball_m, double ball_radius_m);

/// Radius of a ball and the depths at which it has the right size in the image.
struct BallSize {
  double radius_m;
  double nearest_m;
  double farthest_m;
};
[[nodiscard]] BallSize draw_ball_size(RandomGenerator& random, const Stage& stage, double smallest_m);
/// Pattern, gloss and hand.
[[nodiscard]] BallConfig draw_ball_kind(RandomGenerator& random);
/// Sets the colours.
void draw_colours(RandomGenerator& random, BallTone tone, BallConfig& ball);
/// A motion that suits what holds the ball. `rests`: it is at rest all the time. `leaves`: it goes out of the image for a
/// time.
[[nodiscard]] TrajectoryConfig draw_ball_motion(RandomGenerator& random, const Stage& stage,
                                                const BallConfig& ball, const BallSize& size, bool rests,
                                                bool leaves);

}  // namespace saccade::random_world
