#include "sim/sim_eye.h"

#include "core/random.h"

namespace saccade {
namespace {

const Camera& camera_of(const SimConfig& config, std::uint8_t number) {
  return number == 0 ? config.camera : config.right.camera;
}

int model_camera_of(const World& world, std::uint8_t number) {
  return number == 0 ? world.left_eye_camera() : world.right_eye_camera();
}

}  // namespace

SimEye::SimEye(World& world, GlContext& gl, const SimConfig& config, std::uint8_t number, std::uint64_t seed)
    : world_(&world),
      model_camera_(model_camera_of(world, number)),
      number_(number),
      labelled_(config.labels),
      sampler_(config.sampling, ImageMotion(world.model(), model_camera_, camera_of(config, number))),
      camera_(camera_of(config, number)),
      emulator_(config.emulator, camera_of(config, number).size,
                number == 0 ? seed : RandomStream(seed, "right eye").bits(0)),
      luminance_(static_cast<std::size_t>(camera_of(config, number).size.pixels())) {
  const CameraMount& mount = number == 0 ? config.mount : config.right.mount;
  check_config(number == 0 ? "camera.eye_from_camera" : "right_camera.eye_from_camera", mount);
  world.mount_camera(model_camera_, mount.eye_from_camera());
  const bool is_direct = config.render.method == RenderMethod::direct;
  if (is_direct || labelled_)
    renderer_ = std::make_unique<EyeRenderer>(world.model(), gl, camera_, config.render);
  if (!is_direct) keyframes_ = std::make_unique<KeyframeRenderer>(world.model(), gl, camera_, config.render);
  const int ball = mj_name2id(&world.model(), mjOBJ_GEOM, "ball");
  if (ball >= 0) ball_body_ = world.model().geom_bodyid[ball];
  if (labelled_) {
    object_of_geom_ = world.scene_objects();
    objects_.resize(luminance_.size());
  }
}

void SimEye::take_image(std::int64_t t_us, mjData& data) {
  sampler_.take(t_us, data);
  if (keyframes_) {
    keyframes_->render(data, model_camera_, luminance_);
  } else {
    renderer_->render(data, model_camera_, luminance_);
  }
  if (labelled_) {
    renderer_->label(data, model_camera_, object_of_geom_, static_cast<std::uint8_t>(SceneObject::background),
                     objects_);
  }
  events_.clear();
  labels_.clear();
  emulator_.process_image(luminance_, t_us, events_, labelled_ ? &labels_ : nullptr, objects_);
  for (Event& event : events_) event.camera = number_;
  const Eigen::Isometry3d root_from_cam = World::root_from_camera(data, model_camera_);
  if (!world_->has_ball()) return;
  const Eigen::Vector3d ball_m = root_from_cam.inverse() * world_->ball_position_m(data);
  truth_.visible = keyframes_ ? keyframes_->visible_share(ball_m, world_->ball_radius_m(), ball_body_)
                              : renderer_->visible_share(ball_m, world_->ball_radius_m());
}

void SimEye::update_truth() {
  truth_.root_from_cam = World::root_from_camera(world_->data(), model_camera_);
  if (!world_->has_ball()) return;
  truth_.circle = camera().project_sphere(truth_.root_from_cam.inverse() * world_->ball_position_m(),
                                          world_->ball_radius_m());
  if (!truth_.circle) truth_.visible = 0.0;
}

}  // namespace saccade
