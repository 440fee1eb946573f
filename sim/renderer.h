#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "core/camera.h"
#include "core/config.h"
#include "sim/gl_context.h"

namespace saccade {

namespace detail {
class SceneDrawer;
}

struct EyeRenderConfig {
  std::int64_t supersampling = 2;  ///< samples per pixel and direction
  double near_m = 0.02;            ///< nothing nearer along the optical axis is drawn
  double far_m = 12.0;             ///< nor farther
};

/// Keys: supersampling, near_m, far_m.
void describe(FieldVisitor& v, EyeRenderConfig& config);

/// What an eye of the model sees through its lens, as linear luminance.
///
/// Draws geoms of groups 0 and 1 (the robot's own shell is group 2: no eye sees its head from inside),
/// with the lights of the model, but no shadows, reflections or haze. Luminance is Rec. 709's of the
/// drawn colours taken as linear reflectances, in units of one 8-bit grey level, 0 to 255, with fractions.
///
/// MuJoCo 2.2.2 draws exact pinholes with square pixels only. The drawn image holds all that the lens shows,
/// with supersampling^2 samples per pixel on the optical axis; a pixel is the mean of the drawn image over the
/// pixel's area there, so that each sample counts by how much of it the pixel covers. A sphere is drawn as a
/// polyhedron whose outline has the area of the true one.
class EyeRenderer {
 public:
  /// `model` and `gl` must outlive it. Textures are uploaded here: paint them before.
  /// Throws InputError for a config or camera out of range, RunError when OpenGL fails.
  EyeRenderer(const mjModel& model, GlContext& gl, const Camera& camera, const EyeRenderConfig& config);
  ~EyeRenderer();

  /// Draws what the model's fixed camera `camera_id` sees at the state of `data` (kinematics computed;
  /// not changed). `luminance` is row-major, height x width of the camera.
  void render(mjData& data, int camera_id, std::span<float> luminance);

  /// The same in colour: linear red, green and blue, 0 to 255 with fractions, as three images one after the
  /// other in `rgb`. Pixels lie `shift_px` further right and down than the camera has them (through a lens:
  /// those on the optical axis), so that several pictures can share out the samples of one.
  void render_colour(mjData& data, int camera_id, const Eigen::Vector2d& shift_px, std::span<float> rgb);

  /// What each pixel sees, as numbers: `number_of_geom` has one for each geom of the model, from 1 to 254 and
  /// smaller for what is to count in front. A pixel has the smallest number among its samples, `nothing` where
  /// none is drawn. Costs about as much as an image. `numbers`: row-major, height x width of the camera.
  void label(mjData& data, int camera_id, std::span<const std::uint8_t> number_of_geom, std::uint8_t nothing,
             std::span<std::uint8_t> numbers);

  /// The share of a sphere's disc, in [0, 1], that is inside the last image and not hidden by anything
  /// drawn more than 3 mm in front of the sphere. `centre_m` in the (OpenCV) camera frame. 0 for a sphere
  /// that is not wholly in front of the camera.
  [[nodiscard]] double visible_share(const Eigen::Vector3d& centre_m, double radius_m);

  [[nodiscard]] const Camera& camera() const { return camera_; }

 private:
  /// With `number_of_geom` each geom flat in the colour (number, 0, 0).
  void draw(mjData& data, int camera_id, const Eigen::Vector2d& shift_px,
            std::span<const std::uint8_t> number_of_geom = {});
  void gather_samples();
  /// The drawn image's samples, weighted by colour in 1/10000, as seen by the pixels.
  template <std::uint32_t red, std::uint32_t green, std::uint32_t blue>
  void resample(std::span<float> image);

  /// Samples side by side in the drawn image, and what they count in a pixel.
  struct Samples {
    std::uint32_t first;
    std::array<float, 4> weights;
  };

  Camera camera_;
  EyeRenderConfig config_;
  GlContext& gl_;
  int columns_ = 0;               ///< of the drawn image
  int rows_ = 0;                  ///< of the drawn image
  double focal_ = 0.0;            ///< of the drawn image, samples
  double centre_x_ = 0.0;         ///< principal point of the drawn image, samples from its left edge
  double centre_y_ = 0.0;         ///< and from its top edge
  std::vector<Samples> samples_;  ///< of all pixels, row by row
  std::vector<std::uint32_t> samples_end_;  ///< per pixel: where its samples end
  std::vector<std::uint8_t>
      is_inside_;                    ///< per sample of the drawn image: at least half of it is in the image
  std::vector<std::uint32_t> rgba_;  ///< the drawn image, bottom row first
  std::vector<float> drawn_;         ///< its luminance or one colour
  std::vector<float> depth_;
  std::unique_ptr<detail::SceneDrawer> drawer_;
};

/// A camera that a person moves: it looks at a point from a distance.
struct SceneView {
  Eigen::Vector3d look_at_m = Eigen::Vector3d(-0.4, 0.0, 0.2);  ///< root frame
  double distance_m = 1.6;
  double azimuth_rad = 0.0;     ///< heading of the view about z; 0 looks along root x (at the robot's face)
  double elevation_rad = -0.3;  ///< of the view: negative looks down
};

/// Head and ball in profile, from the robot's left, before the lab.
[[nodiscard]] SceneView profile_view();

/// A stick in a picture of the scene that is not in the world: a ray, an edge of a frustum. Root frame.
struct SceneMark {
  Eigen::Vector3d from_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d to_m = Eigen::Vector3d::Zero();
  double radius_m = 0.002;
  std::array<float, 4> rgba = {1.0F, 1.0F, 1.0F, 1.0F};  ///< linear; it glows
};

/// Third-person pictures for reports and videos: everything in the model, finely drawn.
class SceneRenderer {
 public:
  /// `model` and `gl` must outlive it. Throws RunError when OpenGL fails.
  SceneRenderer(const mjModel& model, GlContext& gl, ImageSize size);
  ~SceneRenderer();

  /// `rgb` is row-major, height x width x 3, top row first, sRGB. At most 100 marks.
  void render(mjData& data, const SceneView& view, std::span<std::uint8_t> rgb,
              std::span<const SceneMark> marks = {});

  [[nodiscard]] ImageSize image_size() const { return size_; }

 private:
  ImageSize size_;
  GlContext& gl_;
  std::unique_ptr<detail::SceneDrawer> drawer_;
};

}  // namespace saccade
