#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Geometry>
#include <array>
#include <string>

#include "core/config.h"
#include "sim/trajectory.h"

namespace saccade {

/// Pattern of the sleeve of the arm that holds the ball.
enum class Sleeve { plain, checked };
constexpr auto words_of(Sleeve) {
  return std::to_array<Word<Sleeve>>({{Sleeve::plain, "plain"}, {Sleeve::checked, "checked"}});
}

/// Pattern of the ball's surface.
enum class BallPattern {
  plain,    ///< one colour
  striped,  ///< bands of both colours around an axis
  seams,    ///< lines of the second colour along three great circles
  patches,  ///< twelve round patches of the second colour, as on a football
};
constexpr auto words_of(BallPattern) {
  return std::to_array<Word<BallPattern>>({{BallPattern::plain, "plain"},
                                           {BallPattern::striped, "striped"},
                                           {BallPattern::seams, "seams"},
                                           {BallPattern::patches, "patches"}});
}

/// What holds the ball. Each is a file `hand_*.xml` of models/.
enum class Hand {
  fingers,  ///< a hand from behind and below, its fingers round the ball
  fist,     ///< a closed hand below the ball
  palm,     ///< an open hand below the ball
  sleeve,   ///< the round end of a sleeve behind the ball
  stick,    ///< a stick from below
  string,   ///< a string from above
  none,
};
constexpr auto words_of(Hand) {
  return std::to_array<Word<Hand>>({{Hand::fingers, "fingers"},
                                    {Hand::fist, "fist"},
                                    {Hand::palm, "palm"},
                                    {Hand::sleeve, "sleeve"},
                                    {Hand::stick, "stick"},
                                    {Hand::string, "string"},
                                    {Hand::none, "none"}});
}

/// The ball and what holds it.
struct BallConfig {
  bool present = true;  ///< false: a world without ball and hand
  double diameter_m = 0.095;
  std::array<double, 3> rgb = {0.65, 0.10, 0.07};  ///< linear reflectance
  BallPattern pattern = BallPattern::plain;
  std::array<double, 3> pattern_rgb = {0.05, 0.05, 0.05};  ///< linear reflectance of the pattern
  /// Rotation of the pattern's axes, a rotation vector.
  std::array<double, 3> pattern_turn_deg = {0.0, 0.0, 0.0};
  double gloss = 0.0;  ///< strength of the highlights; 0: matt
  Hand hand = Hand::fingers;
  double hand_turn_deg = 0.0;  ///< rotation of what holds the ball about its centre and the root's x axis
  Sleeve sleeve = Sleeve::plain;
  bool rolls = false;  ///< the ball turns as if it rolled on a horizontal plane
  TrajectoryConfig trajectory;
};

/// Keys: present, diameter_m, rgb, pattern, pattern_rgb, pattern_turn_deg, gloss, hand, hand_turn_deg, sleeve, rolls,
/// trajectory.
void describe(FieldVisitor& v, BallConfig& config);

/// Name of the model file of what holds the ball.
[[nodiscard]] std::string hand_file(const BallConfig& config);
/// MJCF elements that the pattern needs besides ball_in_hand.xml; empty for a plain ball.
[[nodiscard]] std::string pattern_mjcf(const BallConfig& config);

/// Gives the ball of a compiled model (`ball_in_hand.xml` with hand_file() and pattern_mjcf()) its size, colours and hand.
/// Paints its texture: call before a renderer uploads it.
void set_up_ball(mjModel& model, const BallConfig& config);

/// Rotation of a ball that rolls without slipping on a horizontal plane, after it has moved by `moved_m` in a straight
/// line.
[[nodiscard]] Eigen::Quaterniond rolled(const Eigen::Vector3d& moved_m, double radius_m);

/// Share of the pattern's colour in [0, 1] at a point of the ball, a unit vector in the pattern's axes.
[[nodiscard]] double pattern_cover(BallPattern pattern, const Eigen::Vector3d& point);

}  // namespace saccade
