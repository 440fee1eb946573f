#include "worlds/camera_path.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "control/head_kinematics.h"
#include "core/units.h"

namespace saccade {
namespace {

/// An object that may pass before the ball: what it hides across the line of sight.
struct Screen {
  Trajectory trajectory;
  double half_y_m;
  double half_z_m;
};

std::vector<Screen> screens_of(const NamedObjects& objects, std::uint64_t seed) {
  constexpr double hand_m = 0.13;  // from the wrist to the fingertips, and of the forearm as much
  std::vector<Screen> screens;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const ObjectConfig& object = objects[i].second;
    if (object.shape == ObjectShape::person) continue;  // walks behind the ball
    const bool turned =
        object.turn_deg != std::array<double, 3>{} || object.turn_deg_s != std::array<double, 3>{};
    Eigen::Vector3d half_m = 0.5 * object.size_m;
    if (object.shape == ObjectShape::hand) half_m.setConstant(hand_m);
    if (turned) half_m.setConstant(half_m.maxCoeff());
    screens.push_back({Trajectory(object.trajectory, object_seed(seed, i)), half_m.y(), half_m.z()});
  }
  return screens;
}

/// Whether the line from eye to ball passes the plane through the object's centre normal to x within the object, between
/// the two.
bool hides(const Screen& screen, std::int64_t t_us, const Eigen::Vector3d& eye_m,
           const Eigen::Vector3d& ball_m) {
  const Eigen::Vector3d at_m = screen.trajectory.position_m(t_us);
  const double share = (at_m.x() - eye_m.x()) / (ball_m.x() - eye_m.x());
  if (!(share > 0.0 && share < 1.0)) return false;
  const Eigen::Vector3d off_m = eye_m + share * (ball_m - eye_m) - at_m;
  return std::abs(off_m.y()) < screen.half_y_m && std::abs(off_m.z()) < screen.half_z_m;
}

}  // namespace

CameraPath::CameraPath(const ScriptConfig* script, const WorldConfig& world, double duration_s) {
  const auto head = head_model(world.head);
  HeadState state;
  state.position_rad = initial_pose_rad(world, *head);
  MotionLimits limits;  // a script's points lie within the head's
  limits.head = head;
  limits.hardware_min_rad.setConstant(-std::numeric_limits<double>::infinity());
  limits.hardware_max_rad.setConstant(std::numeric_limits<double>::infinity());
  std::optional<ScriptController> controller;
  if (script != nullptr) controller.emplace(*script, limits);
  const auto count = std::llround(duration_s * 1e6) / step_us;
  for (std::int64_t i = 0; i <= count; ++i) {
    root_from_eye_.push_back(HeadKinematics(head->chain, state.position_rad).root_from_eye(Eye::left));
    if (!controller) continue;
    state.position_rad.tail<gaze_slots>() = controller->step(state, std::nullopt, 1e-6 * step_us);
  }
}

BallView view_of(const CameraPath& path, const Camera& camera, const Trajectory& ball, double radius_m,
                 const NamedObjects& objects, std::uint64_t seed) {
  const std::vector<Screen> screens = screens_of(objects, seed);
  BallView view{0.0, 0.0, std::numeric_limits<double>::infinity(), 0.0, 0.0};
  const double width = camera.size.width;
  const double height = camera.size.height;
  int in_view = 0;
  int hidden_count = 0;
  std::optional<Circle> last;
  std::int64_t t_us = 0;
  for (const Eigen::Isometry3d& root_from_eye : path.root_from_eye()) {
    const Eigen::Vector3d ball_m = ball.position_m(t_us);
    const auto circle = camera.project_sphere(root_from_eye.inverse() * ball_m, radius_m);
    const auto lies_within = [&](double margin_px) {
      return circle && circle->x_px > -margin_px && circle->y_px > -margin_px &&
             circle->x_px < width - 1.0 + margin_px && circle->y_px < height - 1.0 + margin_px;
    };
    if (circle && lies_within(circle->r_px)) {
      view.smallest_px = std::min(view.smallest_px, circle->r_px);
      view.largest_px = std::max(view.largest_px, circle->r_px);
    }
    if (lies_within(0.0)) {
      const bool hidden = std::any_of(screens.begin(), screens.end(), [&](const Screen& screen) {
        return hides(screen, t_us, root_from_eye.translation(), ball_m);
      });
      ++(hidden ? hidden_count : in_view);
      if (last) {
        const double moved_px = std::hypot(circle->x_px - last->x_px, circle->y_px - last->y_px);
        view.fastest_px_s = std::max(view.fastest_px_s, 1e6 * moved_px / CameraPath::step_us);
      }
    }
    last = circle;
    t_us += CameraPath::step_us;
  }
  const auto count = static_cast<double>(path.root_from_eye().size());
  view.in_view_share = in_view / count;
  view.hidden_share = hidden_count / count;
  return view;
}

}  // namespace saccade
