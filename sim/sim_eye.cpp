#include "sim/sim_eye.h"

#include <algorithm>

#include "core/random.h"
#include "emulator/event_label.h"

namespace saccade {
namespace {

const Camera& camera_of(const SimConfig& config, std::uint8_t number) {
  return number == 0 ? config.camera : config.right.camera;
}

int model_camera_of(const World& world, std::uint8_t number) {
  return number == 0 ? world.left_eye_camera() : world.right_eye_camera();
}

}  // namespace

SimEye::SimEye(World& world, GlContext& gl, const SimConfig& config, std::uint8_t number, std::uint64_t seed,
               std::shared_ptr<WorkerThreads> threads)
    : world_(&world),
      model_camera_(model_camera_of(world, number)),
      number_(number),
      labelled_(config.labels),
      sampler_(config.sampling, ImageMotion(world.model(), model_camera_, camera_of(config, number))),
      camera_(camera_of(config, number)),
      emulator_(config.emulator, camera_of(config, number).size,
                number == 0 ? seed : RandomStream(seed, "right eye").bits(0), threads),
      luminance_(static_cast<std::size_t>(camera_of(config, number).size.pixels())) {
  const CameraMount& mount = number == 0 ? config.mount : config.right.mount;
  check_config(number == 0 ? "camera.eye_from_camera" : "right_camera.eye_from_camera", mount);
  world.mount_camera(model_camera_, mount.eye_from_camera());
  const bool is_direct = config.render.method == RenderMethod::direct;
  const bool is_measured = world.has_target() && !world.target_radius_m();
  if (is_direct || labelled_ || is_measured) {
    EyeRenderConfig render = config.render;
    if (!is_direct)
      render.supersampling = render.keyframe_samples;  // numbers of objects, as fine as the images
    renderer_ = std::make_unique<EyeRenderer>(world.model(), gl, camera_, render, threads);
  }
  if (!is_direct)
    keyframes_ =
        std::make_unique<KeyframeRenderer>(world.model(), gl, camera_, config.render, std::move(threads));
  target_body_ = world.target_body();
  if (config.lab.flicker) flicker_.emplace(*config.lab.flicker);
  if (labelled_) {
    object_of_geom_ = world.scene_objects();
    objects_.resize(luminance_.size());
  }
  if (!world.has_target() || world.target_radius_m()) return;
  for (const std::uint8_t object : world.scene_objects()) {
    const bool is_target = object == static_cast<std::uint8_t>(SceneObject::ball);
    target_of_geom_.push_back(is_target ? 1 : 2);
    target_alone_of_geom_.push_back(is_target ? 1 : 0);
  }
  target_pixels_.resize(luminance_.size());
}

std::optional<std::int64_t> SimEye::next_image(std::int64_t begin_us, std::int64_t end_us,
                                               const ImageSampler::Show& show) {
  const auto due_us = sampler_.next(begin_us, end_us, show);
  if (!flicker_) return due_us;
  const std::int64_t light_us =
      std::max({begin_us, flicker_->next_image_us(image_us_), image_us_ + held_us_});
  if (light_us > end_us) return due_us;
  return due_us ? std::min(*due_us, light_us) : light_us;
}

void SimEye::hold_back_images(std::int64_t least_us) {
  held_us_ = least_us;
  sampler_.hold_back(least_us);
}

/// What is seen of a target that is no sphere, and the share of it that nothing hides.
void SimEye::measure_target(mjData& data) {
  constexpr std::uint8_t nothing = 3;
  const auto draw = [&](std::span<const std::uint8_t> number_of_geom) {
    renderer_->label(data, model_camera_, number_of_geom, nothing, target_pixels_);
    return std::count(target_pixels_.begin(), target_pixels_.end(), std::uint8_t{1});
  };
  truth_.extent.reset();
  truth_.visible = 0.0;
  const auto whole = draw(target_alone_of_geom_);
  if (whole == 0) return;
  const auto seen = draw(target_of_geom_);
  truth_.visible = static_cast<double>(seen) / static_cast<double>(whole);
  if (seen == 0) return;
  const int width = camera().size.width;
  Eigen::Array2d sum_px = Eigen::Array2d::Zero();
  Eigen::Array2d least_px = Eigen::Array2d::Constant(1e9);
  Eigen::Array2d most_px = -least_px;
  for (std::size_t i = 0; i < target_pixels_.size(); ++i) {
    if (target_pixels_[i] != 1) continue;
    const int column = static_cast<int>(i) % width;
    const int row = static_cast<int>(i) / width;
    const Eigen::Array2d at_px(column, row);
    sum_px += at_px;
    least_px = least_px.min(at_px);
    most_px = most_px.max(at_px);
  }
  truth_.extent = VisibleExtent{sum_px / static_cast<double>(seen), least_px, most_px - least_px + 1.0};
}

void SimEye::take_image(std::int64_t t_us, mjData& data) {
  sampler_.take(t_us, data);
  image_us_ = t_us;
  if (keyframes_) {
    keyframes_->render(data, model_camera_, luminance_);
  } else {
    renderer_->render(data, model_camera_, luminance_);
  }
  if (flicker_) {
    const auto factor = static_cast<float>(flicker_->factor(t_us));
    for (float& luminance : luminance_) luminance *= factor;
  }
  if (labelled_) {
    renderer_->label(data, model_camera_, object_of_geom_, static_cast<std::uint8_t>(SceneObject::background),
                     objects_);
  }
  events_.clear();
  labels_.clear();
  emulator_.process_image(luminance_, t_us, events_, labelled_ ? &labels_ : nullptr, objects_);
  for (Event& event : events_) event.camera = number_;
  if (!world_->has_target()) return;
  if (world_->target_radius_m()) {
    const Eigen::Isometry3d root_from_cam = World::root_from_camera(data, model_camera_);
    shown_target_m_ = root_from_cam.inverse() * world_->target_position_m(data);
  } else {
    measure_target(data);
  }
}

void SimEye::update_truth() {
  truth_.root_from_cam = World::root_from_camera(world_->data(), model_camera_);
  const auto radius_m = world_->target_radius_m();
  if (!world_->has_target() || !radius_m) return;
  if (shown_target_m_) {
    truth_.visible = keyframes_ ? keyframes_->visible_share(*shown_target_m_, *radius_m, target_body_)
                                : renderer_->visible_share(*shown_target_m_, *radius_m);
    shown_target_m_.reset();
  }
  truth_.circle =
      camera().project_sphere(truth_.root_from_cam.inverse() * world_->target_position_m(), *radius_m);
  if (!truth_.circle) truth_.visible = 0.0;
}

}  // namespace saccade
