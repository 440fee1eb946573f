#include "sim/eye_renderer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/error.h"
#include "sim/scene_drawer.h"

namespace saccade {
namespace {

using detail::SceneDrawer;

/// Outlines larger than so many drawn images are measured, not counted sample by sample.
constexpr double largest_counted = 16.0;

/// The samples [first, last) along one image axis that the outline of a sphere spans: its tangent planes
/// through the other axis meet z = 1 at u with (dx - u dz)^2 = R^2 (1 + u^2).
std::array<int, 2> outline_span(double dx, double dz, double radius, double focal, double centre) {
  const double r2 = radius * radius;
  const double root = radius * std::sqrt(std::max(dx * dx + dz * dz - r2, 0.0));
  const double scale = focal / (dz * dz - r2);
  constexpr double farthest = 1e6;  // far outside any image
  return {static_cast<int>(std::clamp(std::floor(centre + scale * (dx * dz - root)), -farthest, farthest)),
          static_cast<int>(std::clamp(std::ceil(centre + scale * (dx * dz + root)), -farthest, farthest))};
}

const Camera& checked(const Camera& camera) {
  check_config("camera", camera);
  const double stretch = camera.fy_px / camera.fx_px;
  if (!(stretch > 0.5 && stretch < 2.0)) {
    throw InputError("camera.fx_px", text_of(camera.fx_px), "between fy / 2 and 2 fy");
  }
  return camera;
}

}  // namespace

void describe(FieldVisitor& v, EyeRenderConfig& config) {
  v.choice("method", config.method, "whether every image is drawn, or reprojected from keyframes");
  v.integer("supersampling", config.supersampling, {1, 8}, "samples per pixel and direction of drawn images");
  v.when(config.method == RenderMethod::keyframes, "method: keyframes", [&] {
    v.integer("keyframe_samples", config.keyframe_samples, {2, 8},
              "samples per pixel and direction of keyframes");
    v.real("keyframe_error_px", config.keyframe_error_px, {0.01, 2.0},
           "bound on the error of reprojection in the image; beyond it a new keyframe is drawn");
  });
  v.real("near_m", config.near_m, {0.001, 0.2}, "nearest drawn surface, along the optical axis");
  v.real("far_m", config.far_m, {1.0, 1000.0}, "farthest drawn surface, along the optical axis");
}

EyeRenderer::EyeRenderer(const mjModel& model, GlContext& gl, const Camera& camera,
                         const EyeRenderConfig& config, std::shared_ptr<WorkerThreads> threads)
    : camera_(camera),
      config_(check_config("render", config)),
      lens_(checked(camera), config.supersampling),
      threads_(std::move(threads)),
      rgba_(lens_.is_inside().size()),
      drawer_(std::make_unique<SceneDrawer>(model, gl, ImageSize{lens_.columns(), lens_.rows()},
                                            SceneDrawer::Quality::fast)) {}

EyeRenderer::~EyeRenderer() = default;

void EyeRenderer::render(mjData& data, int camera_id, std::span<float> luminance) {
  SACCADE_CHECK(luminance.size() == static_cast<std::size_t>(camera_.size.pixels()));
  draw(data, camera_id, Eigen::Vector2d::Zero());
  lens_.luminance(rgba_, luminance, *threads_);
}

void EyeRenderer::render_colour(mjData& data, int camera_id, const Eigen::Vector2d& shift_px,
                                std::span<float> rgb) {
  SACCADE_CHECK(rgb.size() == 3 * static_cast<std::size_t>(camera_.size.pixels()));
  draw(data, camera_id, shift_px);
  lens_.colour(rgba_, rgb, *threads_);
}

void EyeRenderer::label(mjData& data, int camera_id, std::span<const std::uint8_t> number_of_geom,
                        std::uint8_t nothing, std::span<std::uint8_t> numbers) {
  SACCADE_CHECK(numbers.size() == static_cast<std::size_t>(camera_.size.pixels()));
  draw(data, camera_id, Eigen::Vector2d::Zero(), number_of_geom);
  lens_.smallest(rgba_, nothing, numbers);
}

void EyeRenderer::draw(mjData& data, int camera_id, const Eigen::Vector2d& shift_px,
                       std::span<const std::uint8_t> number_of_geom) {
  const Eigen::Vector2d shift(shift_px.x() * lens_.focal() / camera_.fx_px,
                              shift_px.y() * lens_.focal() / camera_.fy_px);
  const mjrRect whole{0, 0, lens_.columns(), lens_.rows()};
  drawer_->draw(data, eye_view(data, camera_id, lens_, config_, shift), whole, number_of_geom);
  drawer_->read_rgba(whole, rgba_.data());
}

mjvGLCamera eye_view(const mjData& data, int camera_id, const LensResampler& lens,
                     const EyeRenderConfig& config, const Eigen::Vector2d& shift) {
  const mjtNum* position = data.cam_xpos + 3 * camera_id;
  const mjtNum* axes = data.cam_xmat + 9 * camera_id;
  mjvGLCamera eye{};
  for (int i = 0; i < 3; ++i) {
    eye.pos[i] = static_cast<float>(position[i]);
    eye.forward[i] = static_cast<float>(-axes[3 * i + 2]);
    eye.up[i] = static_cast<float>(axes[3 * i + 1]);
  }
  const double per_sample = config.near_m / lens.focal();
  const double centre_x = lens.centre_x() - shift.x();
  const double centre_y = lens.centre_y() - shift.y();
  eye.frustum_center = static_cast<float>(per_sample * (0.5 * lens.columns() - centre_x));
  eye.frustum_top = static_cast<float>(per_sample * centre_y);
  eye.frustum_bottom = static_cast<float>(per_sample * (centre_y - lens.rows()));
  eye.frustum_near = static_cast<float>(config.near_m);
  eye.frustum_far = static_cast<float>(config.far_m);
  return eye;
}

double EyeRenderer::visible_share(const Eigen::Vector3d& centre_m, double radius_m) {
  const double depth2 = centre_m.z() * centre_m.z() - radius_m * radius_m;
  if (!(centre_m.z() > radius_m) || !(depth2 > 0.0)) return 0.0;
  const int columns = lens_.columns();
  const int rows = lens_.rows();
  const double focal = lens_.focal();
  auto [left, right] = outline_span(centre_m.x(), centre_m.z(), radius_m, focal, lens_.centre_x());
  auto [top, bottom] = outline_span(centre_m.y(), centre_m.z(), radius_m, focal, lens_.centre_y());
  const mjrRect seen{std::max(left, 0), rows - std::min(bottom, rows),
                     std::min(right, columns) - std::max(left, 0), std::min(bottom, rows) - std::max(top, 0)};
  if (seen.width <= 0 || seen.height <= 0) return 0.0;
  depth_.resize(static_cast<std::size_t>(seen.width) * static_cast<std::size_t>(seen.height));
  drawer_->read_depth(seen, depth_.data());

  const double k = centre_m.squaredNorm() - radius_m * radius_m;
  const double span = config_.far_m - config_.near_m;
  const bool is_large = static_cast<double>(right - left) * static_cast<double>(bottom - top) >
                        largest_counted * static_cast<double>(rgba_.size());
  if (is_large) {
    left = seen.left;
    right = seen.left + seen.width;
    top = std::max(top, 0);
    bottom = std::min(bottom, rows);
  }
  const std::uint8_t* const is_inside = lens_.is_inside().data();
  const float* const depth = depth_.data();
  std::int64_t all = 0;
  std::int64_t visible = 0;
  for (int row = top; row < bottom; ++row) {
    const double ray_y = (row + 0.5 - lens_.centre_y()) / focal;
    const bool row_inside = row >= 0 && row < rows;
    // Valid only inside the drawn image, whose bottom row comes first.
    const std::ptrdiff_t sample_row = static_cast<std::ptrdiff_t>(rows - 1 - row) * columns;
    const std::ptrdiff_t depth_row =
        static_cast<std::ptrdiff_t>(rows - 1 - row - seen.bottom) * seen.width - seen.left;
    for (int column = left; column < right; ++column) {
      const double ray_x = (column + 0.5 - lens_.centre_x()) / focal;
      const double along = centre_m.x() * ray_x + centre_m.y() * ray_y + centre_m.z();
      const double ray2 = ray_x * ray_x + ray_y * ray_y + 1.0;
      const double root2 = along * along - ray2 * k;
      if (root2 < 0.0) continue;
      ++all;
      if (!row_inside || column < 0 || column >= columns) continue;
      if (is_inside[sample_row + column] == 0) continue;
      const double drawn_m = config_.near_m * config_.far_m /
                             (config_.far_m - static_cast<double>(depth[depth_row + column]) * span);
      if (drawn_m > (along - std::sqrt(root2)) / ray2 - hidden_by_m) ++visible;
    }
  }
  if (is_large) {  // the outline is an ellipse with the semi-axes R sqrt(k) / depth2 and R / sqrt(depth2) at z = 1
    const double area =
        std::numbers::pi * radius_m * radius_m * std::sqrt(k) / (depth2 * std::sqrt(depth2)) * focal * focal;
    return std::min(1.0, static_cast<double>(visible) / area);
  }
  return all == 0 ? 0.0 : static_cast<double>(visible) / static_cast<double>(all);
}

}  // namespace saccade
