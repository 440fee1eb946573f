#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/camera.h"
#include "emulator/event_emulator.h"
#include "sim/gl_context.h"
#include "sim/image_sampler.h"
#include "sim/renderer.h"
#include "sim/sim_config.h"
#include "sim/world.h"

namespace saccade {

/// What is really so of one eye at an instant; for recorders and scores, never for core or control.
struct EyeTruth {
  std::optional<Circle> circle;  ///< the true circle in the eye's image; none when the ball is not in front
  /// Share of its disc inside the image and not hidden, as of the newest image; nothing in it has moved by more
  /// than SamplingConfig::max_displacement_px since then.
  double visible = 0.0;
  Eigen::Isometry3d root_from_cam = Eigen::Isometry3d::Identity();
};

/// One eye of the simulated robot: where its camera is in the model, how it draws what it sees, and the event camera
/// that looks at that.
class SimEye {
 public:
  /// `number`: 0 left, 1 right, as Event::camera. Puts the camera into its place in the model; textures are painted
  /// already. `world` and `gl` outlive it. The right eye's pixels are others than the left one's, from the same seed.
  /// Throws InputError for a configuration out of range, RunError when OpenGL fails.
  SimEye(World& world, GlContext& gl, const SimConfig& config, std::uint8_t number, std::uint64_t seed);

  /// The next instant in [begin_us, end_us], a tick of the world, at which an image is due; see ImageSampler.
  [[nodiscard]] std::optional<std::int64_t> next_image(std::int64_t begin_us, std::int64_t end_us,
                                                       const ImageSampler::Show& show) {
    return sampler_.next(begin_us, end_us, show);
  }
  /// Draws the world at t_us, as `data` shows it, and takes what its event camera makes of that.
  void take_image(std::int64_t t_us, mjData& data);
  /// Notes where eye and ball are now.
  void note_truth();

  /// Of the newest image: the events since the one before, sorted by time, and with SimConfig::labels the label of
  /// each.
  [[nodiscard]] std::span<const Event> events() const { return events_; }
  [[nodiscard]] std::span<const EventLabel> labels() const { return labels_; }
  /// The newest image: linear luminance, grey levels 0..255, row by row.
  [[nodiscard]] std::span<const float> image() const { return luminance_; }
  /// Truth: what each of its pixels sees, as SceneObject; empty unless SimConfig::labels.
  [[nodiscard]] std::span<const std::uint8_t> objects() const { return objects_; }
  /// Of the event camera so far.
  [[nodiscard]] const EmulatorCounts& counts() const { return emulator_.counts(); }
  [[nodiscard]] const EyeTruth& truth() const { return truth_; }
  [[nodiscard]] const Camera& camera() const { return renderer_->camera(); }

 private:
  const World* world_;
  int model_camera_;
  std::uint8_t number_;
  bool labelled_;
  ImageSampler sampler_;
  std::unique_ptr<EyeRenderer> renderer_;
  EventEmulator emulator_;
  std::vector<float> luminance_;
  std::vector<Event> events_;
  EyeTruth truth_;
  // These only with labels:
  std::vector<std::uint8_t> object_of_geom_;
  std::vector<std::uint8_t> objects_;
  std::vector<EventLabel> labels_;
};

}  // namespace saccade
