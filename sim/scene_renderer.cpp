#include "sim/scene_renderer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "core/error.h"
#include "core/units.h"
#include "emulator/srgb.h"

namespace saccade {

using detail::SceneDrawer;

SceneView profile_view() {
  SceneView view;
  view.look_at_m = {-0.32, 0.0, 0.27};
  view.distance_m = 1.15;
  view.azimuth_rad = 95.0 * rad_per_deg;
  view.elevation_rad = -0.12;
  return view;
}

SceneRenderer::SceneRenderer(const mjModel& model, GlContext& gl, ImageSize size) : size_(size) {
  if (size.width < 8 || size.height < 8 || size.width > 4096 || size.height > 4096) {
    throw InputError("image size", std::to_string(size.width) + "x" + std::to_string(size.height),
                     "8x8 to 4096x4096");
  }
  drawer_ = std::make_unique<SceneDrawer>(model, gl, size, SceneDrawer::Quality::fine);
}

SceneRenderer::~SceneRenderer() = default;

void SceneRenderer::render(mjData& data, const SceneView& view, std::span<std::uint8_t> rgb,
                           std::span<const SceneMark> marks) {
  const auto row_bytes = 3 * static_cast<std::size_t>(size_.width);
  SACCADE_CHECK(rgb.size() == row_bytes * static_cast<std::size_t>(size_.height));
  const Eigen::Vector3d forward(std::cos(view.elevation_rad) * std::cos(view.azimuth_rad),
                                std::cos(view.elevation_rad) * std::sin(view.azimuth_rad),
                                std::sin(view.elevation_rad));
  const Eigen::Vector3d position = view.look_at_m - view.distance_m * forward;
  mjvGLCamera camera{};
  for (int i = 0; i < 3; ++i) {
    camera.pos[i] = static_cast<float>(position[i]);
    camera.forward[i] = static_cast<float>(forward[i]);
  }
  camera.up[2] = 1.0F;
  camera.frustum_near = 0.03F;
  camera.frustum_far = 12.0F;
  camera.frustum_top = camera.frustum_near * 0.45F;  // 48 degrees from top to bottom
  camera.frustum_bottom = -camera.frustum_top;

  const mjrRect whole{0, 0, size_.width, size_.height};
  drawer_->draw(data, camera, whole, {}, marks);
  drawer_->read_rgb(whole, rgb.data());
  for (std::size_t top = 0, bottom = static_cast<std::size_t>(size_.height) - 1; top < bottom;
       ++top, --bottom) {
    std::swap_ranges(rgb.begin() + static_cast<std::ptrdiff_t>(top * row_bytes),
                     rgb.begin() + static_cast<std::ptrdiff_t>((top + 1) * row_bytes),
                     rgb.begin() + static_cast<std::ptrdiff_t>(bottom * row_bytes));
  }
  static const std::array<std::uint8_t, 256> srgb_of_linear = [] {
    std::array<std::uint8_t, 256> table{};
    for (std::size_t i = 0; i < table.size(); ++i) {
      const double srgb = srgb_from_linear(static_cast<double>(i) / 255.0);
      table[i] = static_cast<std::uint8_t>(std::lround(255.0 * srgb));
    }
    return table;
  }();
  for (std::uint8_t& value : rgb) value = srgb_of_linear[value];
}

}  // namespace saccade
