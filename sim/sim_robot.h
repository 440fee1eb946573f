#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/camera.h"
#include "robot/robot.h"
#include "sim/eye_renderer.h"
#include "sim/gl_context.h"
#include "sim/mujoco_compat.h"
#include "sim/scene_renderer.h"
#include "sim/sim_config.h"
#include "sim/sim_eye.h"
#include "sim/true_image.h"
#include "sim/world.h"

namespace saccade {

/// The ground truth at one instant, for recorders and scores; core and control have no access to it.
struct SimTruth {
  std::int64_t t_us = 0;
  /// Every event up to this time has been delivered: the newest image's time. Later ones come with the next image.
  std::int64_t events_until_us = std::numeric_limits<std::int64_t>::max();
  EyeTruth left;
  std::optional<EyeTruth> right;  ///< if it has a camera
  bool target_is_sphere = true;   ///< else there is no circle, but EyeTruth::extent
  Eigen::Vector3d ball_m =
      Eigen::Vector3d::Zero();  ///< centre of the ball (of the scenario's target), root frame
  JointVector plant_position_rad = JointVector::Zero();
};

/// The simulated robot. Waiting for a time advances the world in ticks of 1 ms: the plant steps, ImageSampler chooses
/// the instants of the images, they are drawn, and the event cameras turn them into events. Both eyes are drawn whenever
/// one of them needs an image. Events after the newest image come with the next one. The ports give what a real robot
/// gives; the ground truth has functions of its own, which only recorders, scores and the window use.
class SimRobot final : public Robot, public Clock, public EventSource, public HeadPort, public ImuPort {
 public:
  /// `threads`: of reprojection and event cameras, the calling one included; results do not depend on it.
  /// Throws InputError for a configuration out of range, RunError if there is no OpenGL.
  SimRobot(const SimConfig& config, std::uint64_t seed, std::size_t threads = 1);

  Clock& clock() override { return *this; }
  EventSource& events() override { return *this; }
  HeadPort* head() override { return this; }
  ImuPort* imu() override { return world_.imu_reading() != nullptr ? this : nullptr; }

  [[nodiscard]] std::int64_t now_us() const override { return world_.now_us(); }
  PortStatus wait_until(std::int64_t t_us) override;

  [[nodiscard]] ImageSize image_size() const override { return config_.camera.size; }
  PortStatus read_until(std::int64_t t_us, std::vector<Event>& events) override;
  [[nodiscard]] std::int64_t heard_us() const override { return now_us(); }
  [[nodiscard]] EventTraffic traffic() const override { return {}; }

  [[nodiscard]] JointLimits limits() const override { return world_.limits(); }
  PortStatus read(HeadState& state) override;
  PortStatus read_imu(ImuReading& reading) override;
  CommandResult command(const HeadCommand& reference_rad) override;
  PortStatus stop() override;

  [[nodiscard]] const SimTruth& truth() const { return truth_; }
  [[nodiscard]] const World& world() const { return world_; }
  [[nodiscard]] std::int64_t first_motion_us() const { return world_.first_motion_us(); }
  /// Ground truth: the cause and the SceneObject of each event that the last read_until() delivered, in their order;
  /// empty unless SimConfig::labels.
  [[nodiscard]] std::span<const EventLabel> delivered_labels() const { return delivered_labels_; }
  /// Images, objects and counts of an eye; null for a right eye without a camera.
  [[nodiscard]] const SimEye& left_eye() const { return eyes_.front(); }
  [[nodiscard]] const SimEye* right_eye() const { return eyes_.size() > 1 ? &eyes_[1] : nullptr; }
  /// Time of the newest image.
  [[nodiscard]] std::int64_t image_us() const { return image_us_; }
  /// Number of images of each eye so far.
  [[nodiscard]] std::int64_t images() const { return images_; }
  /// From now on images come at least least_us after each other, and where that is longer than render.max_interval_ms,
  /// events are late by up to that: less work, and less true events. 0: as configured.
  void hold_back_images(std::int64_t least_us);
  /// Draws the scene from outside; see SceneRenderer::render.
  void draw_scene(const SceneView& view, ImageSize size, std::span<std::uint8_t> rgb);
  /// Draws the image of a colour camera in the place of the left eye's camera at t_us within the last tick,
  /// [now - 1 ms, now]: linear red, green and blue, 0 to 255, three images one after the other, one sample per pixel.
  /// The image lies shift_px further right and down in the pixel grid.
  void draw_left_eye(std::int64_t t_us, const Camera& camera, const Eigen::Vector2d& shift_px,
                     std::span<float> rgb);
  /// Depth and geoms of the image of an eye (0 left, 1 right) now, ground truth.
  void draw_truth(std::size_t eye, TrueImage& image);
  /// The luminance of an eye's image now, drawn directly; linear, 0 to 255, row by row.
  void draw_luminance(std::size_t eye, std::span<float> luminance);
  /// Shared with what else computes between the images.
  [[nodiscard]] const std::shared_ptr<WorkerThreads>& threads() const { return threads_; }
  [[nodiscard]] const std::string& gl_description() const { return gl_->description(); }
  /// "MuJoCo 3.5.0".
  [[nodiscard]] static std::string simulator_version();

 private:
  SimRobot(const SimConfig& config, std::uint64_t seed, const Lab& lab, std::size_t threads);

  [[nodiscard]] std::optional<std::int64_t> next_image(std::int64_t begin_us);
  void take_images(std::int64_t t_us);
  void queue_events();
  void update_truth();
  /// The world at an instant of the last tick; valid until the next call or tick.
  mjData& world_at(std::int64_t t_us);

  SimConfig config_;
  World world_;
  std::unique_ptr<GlContext> gl_;
  std::vector<SimEye> eyes_;  // left, right
  std::unique_ptr<SceneRenderer> scene_;
  std::unique_ptr<EyeRenderer> colour_eye_;
  std::array<std::unique_ptr<TrueImageRenderer>, 2> truth_renderers_;  // these two made when first asked for
  std::array<std::unique_ptr<EyeRenderer>, 2> luminance_renderers_;
  MjDataPtr between_ticks_;
  std::int64_t image_us_ = 0;
  std::int64_t images_ = 0;
  std::vector<Event> events_;       // not yet delivered
  std::vector<EventLabel> labels_;  // of events_; only with labels
  std::vector<EventLabel> delivered_labels_;
  std::size_t delivered_ = 0;
  SimTruth truth_;
  std::shared_ptr<WorkerThreads> threads_;
};

}  // namespace saccade
