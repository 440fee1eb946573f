#include "sim/sim_robot.h"

#include <algorithm>

#include "core/error.h"
#include "core/units.h"

namespace saccade {
SimRobot::SimRobot(const SimConfig& config, std::uint64_t seed, std::size_t threads)
    : SimRobot(config, seed, Lab(config.lab, seed), threads) {}

SimRobot::SimRobot(const SimConfig& config, std::uint64_t seed, const Lab& lab, std::size_t threads)
    : config_(config),
      world_(config.world, lab.mjcf(), seed),
      gl_(GlContext::create(config.gl, config.gl_device)),
      between_ticks_(mj_makeData(&world_.model())),
      threads_(std::make_shared<WorkerThreads>(threads)) {
  if (!between_ticks_) throw RunError("MuJoCo has no memory for the world between ticks");
  if (config.both_eyes() && config.right.camera.size != config.camera.size) {
    throw InputError("right_camera", in_words(config.right.camera.size),
                     "the left camera's image, " + in_words(config.camera.size));
  }
  lab.paint(world_.model());
  eyes_.emplace_back(world_, *gl_, config_, 0, seed, threads_);
  if (config.both_eyes()) eyes_.emplace_back(world_, *gl_, config_, 1, seed, threads_);
  take_images(world_.now_us());
  update_truth();
}

PortStatus SimRobot::wait_until(std::int64_t t_us) {
  while (world_.now_us() < t_us) {
    const std::int64_t begin_us = world_.now_us();
    world_.step();
    while (const auto image_us = next_image(begin_us)) take_images(*image_us);
    update_truth();
  }
  return PortStatus::ok;
}

std::string SimRobot::simulator_version() { return std::string("MuJoCo ") + mj_versionString(); }

mjData& SimRobot::world_at(std::int64_t t_us) {
  if (t_us == world_.now_us()) return world_.data();
  world_.show(t_us, *between_ticks_);
  return *between_ticks_;
}

std::optional<std::int64_t> SimRobot::next_image(std::int64_t begin_us) {
  const auto show = [this](std::int64_t at_us) -> const mjData& { return world_at(at_us); };
  std::optional<std::int64_t> next_us;
  for (SimEye& eye : eyes_) {
    const auto due_us = eye.next_image(begin_us, world_.now_us(), show);
    if (due_us && (!next_us || *due_us < *next_us)) next_us = due_us;
  }
  return next_us;
}

void SimRobot::take_images(std::int64_t t_us) {
  mjData& data = world_at(t_us);
  for (SimEye& eye : eyes_) eye.take_image(t_us, data);
  queue_events();
  image_us_ = t_us;
  ++images_;
}

void SimRobot::hold_back_images(std::int64_t least_us) {
  for (SimEye& eye : eyes_) eye.hold_back_images(least_us);
}

void SimRobot::queue_events() {
  const std::span<const Event> left = eyes_.front().events();
  const std::span<const Event> right = eyes_.size() > 1 ? eyes_[1].events() : std::span<const Event>{};
  for (std::size_t i = 0, j = 0; i < left.size() || j < right.size();) {
    const bool is_left = j == right.size() || (i < left.size() && left[i].t_us <= right[j].t_us);
    if (config_.labels) labels_.push_back(is_left ? eyes_[0].labels()[i] : eyes_[1].labels()[j]);
    events_.push_back(is_left ? left[i++] : right[j++]);
  }
}

void SimRobot::update_truth() {
  for (SimEye& eye : eyes_) eye.update_truth();
  truth_.t_us = world_.now_us();
  truth_.events_until_us = image_us_;
  truth_.left = eyes_.front().truth();
  if (eyes_.size() > 1) truth_.right = eyes_[1].truth();
  truth_.target_is_sphere = !world_.has_target() || world_.target_radius_m().has_value();
  truth_.ball_m = world_.target_position_m();
  truth_.plant_position_rad = world_.joints_rad();
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

PortStatus SimRobot::read_imu(ImuReading& reading) {
  reading = *world_.imu_reading();
  return PortStatus::ok;
}

HeadPort::CommandResult SimRobot::command(const HeadCommand& reference_rad) {
  return {PortStatus::ok, !world_.set_reference(reference_rad)};
}

PortStatus SimRobot::stop() {
  HeadState state;
  read(state);
  const JointLimits bounds = limits();
  world_.set_reference(state.head_position_rad()
                           .cwiseMax(bounds.min_rad.tail<gaze_slots>())
                           .cwiseMin(bounds.max_rad.tail<gaze_slots>()));
  return PortStatus::ok;
}

void SimRobot::draw_scene(const SceneView& view, ImageSize size, std::span<std::uint8_t> rgb) {
  if (!scene_ || scene_->image_size() != size) {
    scene_ = std::make_unique<SceneRenderer>(world_.model(), *gl_, size);
  }
  scene_->render(world_.data(), view, rgb);
}

void SimRobot::draw_truth(std::size_t eye, TrueImage& image) {
  auto& renderer = truth_renderers_.at(eye);
  if (!renderer)
    renderer =
        std::make_unique<TrueImageRenderer>(world_.model(), *gl_, eyes_.at(eye).camera(), config_.render);
  renderer->render(world_.data(), eye == 0 ? world_.left_eye_camera() : world_.right_eye_camera(), image);
}

void SimRobot::draw_luminance(std::size_t eye, std::span<float> luminance) {
  auto& renderer = luminance_renderers_.at(eye);
  if (!renderer)
    renderer =
        std::make_unique<EyeRenderer>(world_.model(), *gl_, eyes_.at(eye).camera(), config_.render, threads_);
  renderer->render(world_.data(), eye == 0 ? world_.left_eye_camera() : world_.right_eye_camera(), luminance);
  if (!config_.lab.flicker) return;
  const auto factor = static_cast<float>(Flicker(*config_.lab.flicker).factor(world_.now_us()));
  for (float& value : luminance) value *= factor;
}

void SimRobot::draw_left_eye(std::int64_t t_us, const Camera& camera, const Eigen::Vector2d& shift_px,
                             std::span<float> rgb) {
  if (!colour_eye_ || colour_eye_->camera() != camera) {
    EyeRenderConfig single = config_.render;
    single.supersampling = 1;
    colour_eye_ = std::make_unique<EyeRenderer>(world_.model(), *gl_, camera, single, threads_);
  }
  colour_eye_->render_colour(world_at(t_us), world_.left_eye_camera(), shift_px, rgb);
  if (!config_.lab.flicker) return;
  const auto factor = static_cast<float>(Flicker(*config_.lab.flicker).factor(t_us));
  for (float& value : rgb) value *= factor;
}

}  // namespace saccade
