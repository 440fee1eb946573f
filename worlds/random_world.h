#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "control/script_controller.h"
#include "core/camera.h"
#include "core/config.h"
#include "sim/sim_config.h"

namespace saccade {

/// Where a scenario's world comes from.
enum class WorldFamily {
  random,  ///< drawn from the seed
};
constexpr auto words_of(WorldFamily) {
  return std::to_array<Word<WorldFamily>>({{WorldFamily::random, "random"}});
}

/// Whether a random world has a ball.
enum class WithBall {
  drawn,  ///< in four worlds of five
  always,
  never,
};
constexpr auto words_of(WithBall) {
  return std::to_array<Word<WithBall>>(
      {{WithBall::drawn, "drawn"}, {WithBall::always, "always"}, {WithBall::never, "never"}});
}

/// The section `world` of a scenario: the defaults of ball, hand, room, objects, light, sensor, camera, motion of eyes
/// and neck, and duration are drawn from the seed. docs/worlds.md has what is drawn.
struct RandomWorldConfig {
  WorldFamily family = WorldFamily::random;
  WithBall with_ball = WithBall::drawn;
};

/// Keys: family, with_ball.
void describe(FieldVisitor& v, RandomWorldConfig& config);

/// The range of radii, px, that holds for a ball in an image of this size, [4, 0.3 height rounded down]: the ball of
/// a random world keeps it wherever it is in view, and detectors of a random world have it as default.
[[nodiscard]] std::array<double, 2> radius_range_px(ImageSize size);

/// How the head of a random world moves.
enum class HeadMotion { still, eyes, neck, both };

/// Brightness of a random world's ball.
enum class BallTone { darker, brighter, middle };

/// A world that is drawn.
struct DrawnWorld {
  double duration_s = 4.0;
  SimConfig sim;
  HeadMotion motion = HeadMotion::still;
  ScriptConfig script;  ///< positions of eyes and neck in turn; without motion not used
  // Of the ball, where there is one:
  BallTone tone = BallTone::middle;  ///< than the room, or as bright as it
  double in_view_share = 0.0;        ///< instants with its centre in the image and no object before it
  double hidden_share = 0.0;         ///< instants with its centre in the image behind an object
  double smallest_px = 0.0;          ///< its radius while any part of it is in the image
  double largest_px = 0.0;
  double contrast_share = 0.0;  ///< outline with a contrast of two thresholds or more against the room
};

/// Draws a world. The same configuration, seed and camera give the same world.
/// `camera`: the left eye's camera where the scenario gives it; else it is drawn too.
[[nodiscard]] DrawnWorld draw_world(const RandomWorldConfig& config, std::uint64_t seed,
                                    const std::optional<Camera>& camera);

}  // namespace saccade
