#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/camera.h"
#include "emulator/event_emulator.h"
#include "sim/eye_renderer.h"
#include "sim/flicker.h"
#include "sim/gl_context.h"
#include "sim/image_sampler.h"
#include "sim/keyframe_renderer.h"
#include "sim/sim_config.h"
#include "sim/world.h"
#include "threads/worker_threads.h"

namespace saccade {

/// The part of a target that is seen in an image.
struct VisibleExtent {
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();  ///< mean of its pixels
  Eigen::Vector2d corner_px =
      Eigen::Vector2d::Zero();                        ///< centre of the top left pixel of the box around them
  Eigen::Vector2d size_px = Eigen::Vector2d::Zero();  ///< width and height of the box
};

/// The ground truth of one eye at an instant, for recorders and scores; core and control have no access to it.
struct EyeTruth {
  std::optional<Circle>
      circle;  ///< the true circle in the eye's image; none if the target is not in front of it, absent or no sphere
  /// For a target that is no sphere: what is seen of it in the newest image; none if nothing is.
  std::optional<VisibleExtent> extent;
  /// Share of the ball's disc inside the image and not hidden, [0, 1], as of the newest image. Nothing in the image
  /// has moved by more than SamplingConfig::max_displacement_px since then. For a target that is no sphere, share of its
  /// pixels in the image that nothing hides.
  double visible = 0.0;
  Eigen::Isometry3d root_from_cam = Eigen::Isometry3d::Identity();
};

/// One eye of the simulated robot: the camera in the model, its renderer, and the event camera that converts the images
/// to events.
class SimEye {
 public:
  /// `number`: 0 left, 1 right, as Event::camera. Moves the model's camera to its pose in the eye. The model's textures
  /// are painted already; `world` and `gl` outlive it. From the same seed the two eyes draw different mismatch and noise.
  /// `threads` share the work of an image; results do not depend on them.
  /// Throws InputError for a configuration out of range, RunError when OpenGL fails.
  SimEye(World& world, GlContext& gl, const SimConfig& config, std::uint8_t number, std::uint64_t seed,
         std::shared_ptr<WorkerThreads> threads);

  /// The next instant in [begin_us, end_us], a tick of the world, at which an image is due; see ImageSampler and Flicker.
  [[nodiscard]] std::optional<std::int64_t> next_image(std::int64_t begin_us, std::int64_t end_us,
                                                       const ImageSampler::Show& show);
  /// ImageSampler::hold_back, for the images that follow the light too.
  void hold_back_images(std::int64_t least_us);
  /// Draws the world at t_us, whose state is `data`, and replaces events() by the events since the previous image.
  void take_image(std::int64_t t_us, mjData& data);
  /// Updates truth() to the world's state now.
  void update_truth();

  /// The events between the two newest images, sorted by time, and with SimConfig::labels their labels.
  [[nodiscard]] std::span<const Event> events() const { return events_; }
  [[nodiscard]] std::span<const EventLabel> labels() const { return labels_; }
  /// The newest image: linear luminance, grey levels 0..255, row by row.
  [[nodiscard]] std::span<const float> image() const { return luminance_; }
  /// Ground truth: the SceneObject in each pixel of the newest image; empty unless SimConfig::labels.
  [[nodiscard]] std::span<const std::uint8_t> objects() const { return objects_; }
  /// Counts of the event camera since the start.
  [[nodiscard]] const EmulatorCounts& counts() const { return emulator_.counts(); }
  [[nodiscard]] const EyeTruth& truth() const { return truth_; }
  [[nodiscard]] const Camera& camera() const { return camera_; }
  /// The renderer of keyframes; null with `method: direct`.
  [[nodiscard]] const KeyframeRenderer* keyframes() const { return keyframes_.get(); }

 private:
  void measure_target(mjData& data);

  const World* world_;
  int model_camera_;
  int target_body_ = -1;
  std::uint8_t number_;
  bool labelled_;
  std::optional<Flicker> flicker_;
  std::int64_t image_us_ = 0;  ///< of the newest image
  std::int64_t held_us_ = 0;
  ImageSampler sampler_;
  Camera camera_;
  std::unique_ptr<EyeRenderer> renderer_;        // draws images, and labels with both methods
  std::unique_ptr<KeyframeRenderer> keyframes_;  // instead of drawn images
  EventEmulator emulator_;
  std::vector<float> luminance_;
  std::vector<Event> events_;
  EyeTruth truth_;
  /// A sphere's middle in the camera's frame at the newest image, until update_truth() has taken what is visible of it.
  std::optional<Eigen::Vector3d> shown_target_m_;
  // Empty for a sphere:
  std::vector<std::uint8_t> target_of_geom_;        ///< 1 target, 2 others
  std::vector<std::uint8_t> target_alone_of_geom_;  ///< 1 target, 0 others
  std::vector<std::uint8_t> target_pixels_;
  // Empty without labels:
  std::vector<std::uint8_t> object_of_geom_;
  std::vector<std::uint8_t> objects_;
  std::vector<EventLabel> labels_;
};

}  // namespace saccade
