#include "sim/sim_robot.h"

#include <algorithm>

#include "core/error.h"

namespace saccade {

SimRobot::SimRobot(const SimConfig& config, std::uint64_t seed)
    : config_(config),
      world_(config.world, lab_mjcf(config.lab, seed), seed),
      gl_(GlContext::create(config.gl)),
      emulator_(config.emulator, config.camera.size, seed),
      luminance_(static_cast<std::size_t>(config.camera.size.pixels())) {
  paint_lab_textures(world_.model(), config.lab, seed);
  eye_ = std::make_unique<EyeRenderer>(world_.model(), *gl_, config.camera, config.render);
  look();
}

PortStatus SimRobot::wait_until(std::int64_t t_us) {
  while (world_.now_us() < t_us) {
    world_.step();
    look();
  }
  return PortStatus::ok;
}

void SimRobot::look() {
  const std::int64_t now_us = world_.now_us();
  eye_->render(world_.data(), world_.left_eye_camera(), luminance_);
  emulator_.process_image(luminance_, now_us, events_);

  truth_.t_us = now_us;
  truth_.ball_m = world_.ball_position_m();
  truth_.root_from_left_cam = world_.root_from_left_cam();
  truth_.plant_position_rad = world_.head_state().position_rad;
  const Eigen::Vector3d ball_in_cam_m = truth_.root_from_left_cam.inverse() * truth_.ball_m;
  truth_.circle = config_.camera.project_sphere(ball_in_cam_m, world_.ball_radius_m());
  truth_.visible = truth_.circle ? eye_->visible_share(ball_in_cam_m, world_.ball_radius_m()) : 0.0;
}

PortStatus SimRobot::read_until(std::int64_t t_us, std::vector<Event>& events) {
  const auto begin = events_.begin() + static_cast<std::ptrdiff_t>(delivered_);
  const auto end =
      std::upper_bound(begin, events_.end(), t_us, [](std::int64_t t, const Event& e) { return t < e.t_us; });
  events.insert(events.end(), begin, end);
  delivered_ = static_cast<std::size_t>(end - events_.begin());
  if (delivered_ == events_.size()) {
    events_.clear();
    delivered_ = 0;
  }
  return PortStatus::ok;
}

PortStatus SimRobot::read(HeadState& state) {
  state = world_.head_state();
  return PortStatus::ok;
}

HeadPort::CommandResult SimRobot::command(const HeadCommand& reference_rad) {
  return {PortStatus::ok, !world_.set_reference(reference_rad)};
}

void SimRobot::draw_scene(const SceneView& view, ImageSize size, std::span<std::uint8_t> rgb) {
  if (!scene_ || scene_->image_size() != size) {
    scene_ = std::make_unique<SceneRenderer>(world_.model(), *gl_, size);
  }
  scene_->render(world_.data(), view, rgb);
}

void SimRobot::draw_left_eye(std::int64_t t_us, const PinholeCamera& camera, const Eigen::Vector2d& shift_px,
                             std::span<float> rgb) {
  if (!colour_eye_ || colour_eye_->camera() != camera) {
    EyeRenderConfig single = config_.render;
    single.supersampling = 1;
    colour_eye_ = std::make_unique<EyeRenderer>(world_.model(), *gl_, camera, single);
  }
  if (!shown_) shown_.reset(mj_makeData(&world_.model()));
  if (!shown_) throw RunError("MuJoCo has no memory for a second picture of the world");
  world_.show(t_us, *shown_);
  colour_eye_->render_colour(*shown_, world_.left_eye_camera(), shift_px, rgb);
}

}  // namespace saccade
