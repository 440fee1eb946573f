#include "sim/sim_robot.h"

#include <algorithm>

#include "core/error.h"

namespace saccade {

SimRobot::SimRobot(const SimConfig& config, std::uint64_t seed)
    : config_(config),
      world_(config.world, lab_mjcf(config.lab, seed), seed),
      gl_(GlContext::create(config.gl)),
      shown_(mj_makeData(&world_.model())),
      sampler_(config.sampling, ImageMotion(world_.model(), world_.left_eye_camera(), config.camera)),
      emulator_(config.emulator, config.camera.size, seed),
      luminance_(static_cast<std::size_t>(config.camera.size.pixels())) {
  if (!shown_) throw RunError("MuJoCo has no memory for a second picture of the world");
  check_config("camera.eye_from_camera", config.mount);
  world_.mount_left_camera(config.mount.eye_from_camera());
  paint_lab_textures(world_.model(), config.lab, seed);
  eye_ = std::make_unique<EyeRenderer>(world_.model(), *gl_, config.camera, config.render);
  if (config.labels) {
    object_of_geom_ = world_.scene_objects();
    objects_.resize(luminance_.size());
  }
  take_image(world_.now_us());
  note_truth();
}

PortStatus SimRobot::wait_until(std::int64_t t_us) {
  const auto show = [this](std::int64_t at_us) -> const mjData& { return world_at(at_us); };
  while (world_.now_us() < t_us) {
    const std::int64_t begin_us = world_.now_us();
    world_.step();
    while (const auto image_us = sampler_.next(begin_us, world_.now_us(), show)) take_image(*image_us);
    note_truth();
  }
  return PortStatus::ok;
}

mjData& SimRobot::world_at(std::int64_t t_us) {
  if (t_us == world_.now_us()) return world_.data();
  world_.show(t_us, *shown_);
  return *shown_;
}

void SimRobot::take_image(std::int64_t t_us) {
  mjData& data = world_at(t_us);
  sampler_.take(t_us, data);
  eye_->render(data, world_.left_eye_camera(), luminance_);
  if (config_.labels) {
    eye_->label(data, world_.left_eye_camera(), object_of_geom_,
                static_cast<std::uint8_t>(SceneObject::background), objects_);
  }
  emulator_.process_image(luminance_, t_us, events_, config_.labels ? &labels_ : nullptr, objects_);
  const Eigen::Isometry3d root_from_cam = World::root_from_camera(data, world_.left_eye_camera());
  truth_.visible =
      eye_->visible_share(root_from_cam.inverse() * world_.ball_position_m(data), world_.ball_radius_m());
  image_us_ = t_us;
  ++images_;
}

void SimRobot::note_truth() {
  truth_.t_us = world_.now_us();
  truth_.ball_m = world_.ball_position_m();
  truth_.root_from_left_cam = world_.root_from_left_cam();
  truth_.plant_position_rad = world_.joints_rad();
  const Eigen::Vector3d ball_in_cam_m = truth_.root_from_left_cam.inverse() * truth_.ball_m;
  truth_.circle = config_.camera.project_sphere(ball_in_cam_m, world_.ball_radius_m());
  if (!truth_.circle) truth_.visible = 0.0;
}

PortStatus SimRobot::read_until(std::int64_t t_us, std::vector<Event>& events) {
  const auto begin = events_.begin() + static_cast<std::ptrdiff_t>(delivered_);
  const auto end =
      std::upper_bound(begin, events_.end(), t_us, [](std::int64_t t, const Event& e) { return t < e.t_us; });
  events.insert(events.end(), begin, end);
  if (config_.labels) {
    delivered_labels_.assign(labels_.begin() + (begin - events_.begin()),
                             labels_.begin() + (end - events_.begin()));
  }
  delivered_ = static_cast<std::size_t>(end - events_.begin());
  if (delivered_ == events_.size()) {
    events_.clear();
    labels_.clear();
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

void SimRobot::draw_left_eye(std::int64_t t_us, const Camera& camera, const Eigen::Vector2d& shift_px,
                             std::span<float> rgb) {
  if (!colour_eye_ || colour_eye_->camera() != camera) {
    EyeRenderConfig single = config_.render;
    single.supersampling = 1;
    colour_eye_ = std::make_unique<EyeRenderer>(world_.model(), *gl_, camera, single);
  }
  colour_eye_->render_colour(world_at(t_us), world_.left_eye_camera(), shift_px, rgb);
}

}  // namespace saccade
