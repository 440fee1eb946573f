#include "sim/keyframe_renderer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/error.h"
#include "sim/scene_drawer.h"
#include "sim/world.h"

namespace saccade {
namespace {

using detail::Keyframe;
using detail::SampleRect;
using detail::SceneDrawer;

constexpr std::size_t most_fragments = 8;  ///< per pixel; farther ones of more are left out
constexpr float least_cover = 1.0F / 1024.0F;

/// Pixels that the eye can turn before the room's keyframe ends.
double keyframe_margin_px(const Camera& camera) { return std::max(6.0, camera.size.width / 8.0); }

/// Into how many bands threads share the rows of an image: bodies are in some of them.
std::size_t bands_of(std::size_t rows, std::size_t threads) {
  constexpr std::size_t least_rows = 16;
  constexpr std::size_t per_thread = 8;
  if (threads == 1) return 1;
  return std::clamp(rows / least_rows, std::size_t{1}, per_thread * threads);
}

/// Rays along the border of the image.
std::vector<Eigen::Vector3d> border_rays(const Camera& camera) {
  constexpr int per_side = 4;
  std::vector<Eigen::Vector3d> rays;
  for (int i = 0; i <= per_side; ++i) {
    const double x = camera.size.width * i / static_cast<double>(per_side) - 0.5;
    const double y = camera.size.height * i / static_cast<double>(per_side) - 0.5;
    for (const double end : {-0.5, camera.size.height - 0.5}) rays.push_back(camera.ray(x, end));
    for (const double end : {-0.5, camera.size.width - 0.5}) rays.push_back(camera.ray(end, y));
  }
  return rays;
}

Eigen::Vector3d middle_of(const detail::SceneLayer& layer, const mjData& data) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const int geom : layer.geoms) sum += Eigen::Map<const Eigen::Vector3d>(data.geom_xpos + 3 * geom);
  return layer.geoms.empty() ? sum : Eigen::Vector3d(sum / static_cast<double>(layer.geoms.size()));
}

}  // namespace

KeyframeRenderer::KeyframeRenderer(const mjModel& model, GlContext& gl, const Camera& camera,
                                   const EyeRenderConfig& config, std::shared_ptr<WorkerThreads> threads)
    : camera_(camera),
      config_(check_config("render", config)),
      key_camera_(check_config("camera", camera), config.keyframe_samples, keyframe_margin_px(camera)),
      rule_(key_camera_, border_rays(camera), config.keyframe_error_px),
      filter_(key_camera_),
      drawer_(std::make_unique<SceneDrawer>(model, gl, ImageSize{key_camera_.columns(), key_camera_.rows()},
                                            SceneDrawer::Quality::fast)),
      model_(&model),
      threads_(std::move(threads)) {
  const auto pixels = static_cast<std::size_t>(camera.size.pixels());
  for (detail::SceneLayer& layer : detail::scene_layers(model)) {
    Sheet& sheet = sheets_.emplace_back();
    sheet.layer = std::move(layer);
    sheet.inverse_depth_1_m.resize(pixels);
    if (sheet.layer.is_room()) continue;
    sheet.luminance.resize(pixels);
    sheet.cover.resize(pixels);
  }
  for (int y = 0; y < camera.size.height; ++y) {
    for (int x = 0; x < camera.size.width; ++x) {
      const Eigen::Vector3d ray = camera.ray(x, y);
      const Eigen::Vector3d along_row = camera.ray(x + 0.5, y) - camera.ray(x - 0.5, y);
      const Eigen::Vector3d along_column = camera.ray(x, y + 0.5) - camera.ray(x, y - 0.5);
      ray_x_.push_back(static_cast<float>(ray.x()));
      ray_y_.push_back(static_cast<float>(ray.y()));
      ray_slope_.push_back({static_cast<float>(along_row.x()), static_cast<float>(along_row.y()),
                            static_cast<float>(along_column.x()), static_cast<float>(along_column.y())});
    }
  }
  const auto width = static_cast<std::size_t>(camera.size.width);
  scratch_.resize(bands_of(static_cast<std::size_t>(camera.size.height), threads_->threads()),
                  {std::vector<float>(width), std::vector<float>(width), std::vector<int>(width), {}});
  for (Scratch& scratch : scratch_) scratch.bodies.reserve(sheets_.size());
}

KeyframeRenderer::~KeyframeRenderer() = default;

void KeyframeRenderer::render(mjData& data, int camera_id, std::span<float> luminance) {
  SACCADE_CHECK(luminance.size() == ray_x_.size());
  mjvGLCamera eye{};
  for (int i = 0; i < 3; ++i) {
    eye.pos[i] = static_cast<float>(data.cam_xpos[3 * camera_id + i]);
    eye.forward[i] = static_cast<float>(-data.cam_xmat[9 * camera_id + 3 * i + 2]);
    eye.up[i] = static_cast<float>(data.cam_xmat[9 * camera_id + 3 * i + 1]);
  }
  eye.frustum_near = static_cast<float>(config_.near_m);
  eye.frustum_far = static_cast<float>(config_.far_m);
  detail::read_lights(*model_, data, light_);
  if (light_ != keyframe_light_) {
    keyframe_light_ = light_;
    for (Sheet& sheet : sheets_) sheet.keyframe.is_drawn = false;
  }
  const Eigen::Isometry3d camera_from_root = World::root_from_camera(data, camera_id).inverse();
  for (Sheet& sheet : sheets_) update(sheet, data, eye, camera_from_root);
  threads_->run(scratch_.size(), [&](std::size_t band) {
    const auto height = static_cast<std::size_t>(camera_.size.height);
    const int top = static_cast<int>(height * band / scratch_.size());
    const int bottom = static_cast<int>(height * (band + 1) / scratch_.size());
    for (Sheet& sheet : sheets_)
      reproject_rows(sheet, top, bottom, sheet.layer.is_room() ? luminance : sheet.luminance, scratch_[band]);
    compose_rows(luminance, top, bottom, scratch_[band]);
  });
}

void KeyframeRenderer::update(Sheet& sheet, mjData& data, const mjvGLCamera& eye,
                              const Eigen::Isometry3d& camera_from_root) {
  const detail::SceneLayer& layer = sheet.layer;
  const Eigen::Isometry3d root_from_layer = layer.root_from_layer(data);
  const Eigen::Isometry3d camera_from_layer = camera_from_root * root_from_layer;
  sheet.pixels = {};
  Keyframe found;
  if (!find_rect(sheet, data, camera_from_root, found)) return;
  const Eigen::Vector3d middle_m = root_from_layer.inverse() * middle_of(layer, data);
  Keyframe& keyframe = sheet.keyframe;
  if (!rule_.permits(keyframe, layer, middle_m, camera_from_layer, root_from_layer.linear())) {
    keyframe.drawn = found.drawn;
    keyframe.is_clipped = found.is_clipped;
    keyframe.camera_from_layer = camera_from_layer;
    keyframe.root_from_layer = root_from_layer.linear();
    draw(sheet, data, eye);
    if (keyframe.rect.is_empty()) {
      keyframe.nearest_1_m = found.nearest_1_m;
      keyframe.farthest_1_m = found.farthest_1_m;
    }
  }
  if (!keyframe.rect.is_empty()) prepare(sheet, camera_from_layer);
}

/// Sets drawn, is_clipped and the bounds of depth of a keyframe drawn now. Returns false if the layer is not in the image.
bool KeyframeRenderer::find_rect(const Sheet& sheet, const mjData& data,
                                 const Eigen::Isometry3d& camera_from_root, Keyframe& keyframe) const {
  keyframe.drawn = key_camera_.whole();
  keyframe.nearest_1_m = 1.0 / config_.near_m;
  keyframe.farthest_1_m = 1.0 / config_.far_m;
  keyframe.is_clipped = true;
  if (sheet.layer.is_room()) return true;
  constexpr int everywhere = std::numeric_limits<int>::max();
  SampleRect all{everywhere, everywhere, -everywhere, -everywhere};
  double nearest_m = config_.far_m;
  double farthest_m = config_.near_m;
  for (const int geom : sheet.layer.geoms) {
    const Eigen::Vector3d centre_m =
        camera_from_root * Eigen::Map<const Eigen::Vector3d>(data.geom_xpos + 3 * geom);
    const double radius_m = model_->geom_rbound[geom];
    if (centre_m.z() + radius_m < config_.near_m) continue;  // behind the camera
    const auto span = key_camera_.span_of(centre_m, radius_m, config_.near_m);
    if (!span) return true;
    all = {std::min(all.left, span->left), std::min(all.top, span->top), std::max(all.right, span->right),
           std::max(all.bottom, span->bottom)};
    nearest_m = std::min(nearest_m, centre_m.z() - radius_m);
    farthest_m = std::max(farthest_m, centre_m.z() + radius_m);
  }
  const int border = 2 * key_camera_.samples() + 2;  // more than a pixel around the layer stays empty
  const SampleRect wanted{all.left - border, all.top - border, all.right + border, all.bottom + border};
  if (all.left == everywhere) return false;
  keyframe.drawn = wanted.cut(key_camera_.whole());
  if (keyframe.drawn.is_empty()) return false;
  keyframe.is_clipped = keyframe.drawn.left > wanted.left || keyframe.drawn.top > wanted.top ||
                        keyframe.drawn.right < wanted.right || keyframe.drawn.bottom < wanted.bottom;
  keyframe.nearest_1_m = 1.0 / nearest_m;
  keyframe.farthest_1_m = 1.0 / farthest_m;
  return true;
}

void KeyframeRenderer::draw(Sheet& sheet, mjData& data, mjvGLCamera eye) {
  Keyframe& keyframe = sheet.keyframe;
  const SampleRect& drawn = keyframe.drawn;
  key_camera_.set_frustum(drawn, eye);
  const mjrRect area{0, 0, drawn.columns(), drawn.rows()};
  if (rgba_.size() < drawn.area()) {
    rgba_.resize(drawn.area());
    depth_.resize(drawn.area());
  }
  drawer_->draw_some(data, eye, area, sheet.layer.is_shown);
  drawer_->read_depth(area, depth_.data());
  keyframe.rect = sheet.layer.is_room() ? drawn : filter_.covered_part(drawn, depth_);
  keyframe.is_drawn = true;
  ++(sheet.layer.is_room() ? counts_.room : counts_.bodies);
  counts_.samples += static_cast<std::int64_t>(drawn.area());
  if (keyframe.rect.is_empty()) return;
  const mjrRect part{keyframe.rect.left - drawn.left, drawn.bottom - keyframe.rect.bottom,
                     keyframe.rect.columns(), keyframe.rect.rows()};
  drawer_->read_rgba(part, rgba_.data());
  if (keyframe.rect.area() < drawn.area()) drawer_->read_depth(part, depth_.data());
  filter_.fill(keyframe, {rgba_, depth_, config_.near_m, config_.far_m, sheet.layer.is_room()}, *threads_);
}

/// The pixels that a keyframe is reprojected to, at all of its depths.
KeyframeRenderer::PixelRect KeyframeRenderer::pixels_of(const Keyframe& key,
                                                        const Eigen::Isometry3d& camera_from_key) const {
  const PixelRect whole{0, 0, camera_.size.width, camera_.size.height};
  Eigen::Vector2d low = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector2d high = -low;
  constexpr int per_side = 2;
  for (int i = 0; i <= per_side; ++i) {
    for (int j = 0; j <= per_side; ++j) {
      const Eigen::Vector3d ray(
          (key.rect.left + key.rect.columns() * i / static_cast<double>(per_side) - key_camera_.centre_x()) /
              key_camera_.focal(),
          (key.rect.top + key.rect.rows() * j / static_cast<double>(per_side) - key_camera_.centre_y()) /
              key_camera_.focal(),
          1.0);
      for (const double inverse_depth_1_m : {key.nearest_1_m, key.farthest_1_m}) {
        const auto at_px = camera_.project(camera_from_key * (ray / inverse_depth_1_m));
        if (!at_px) return whole;
        low = low.cwiseMin(*at_px);
        high = high.cwiseMax(*at_px);
      }
    }
  }
  constexpr double bent = 2.0;  // the lens bends the sides of the rectangle
  const auto inside = [](double at, int size) {
    return static_cast<int>(std::clamp(at, 0.0, static_cast<double>(size)));
  };
  return {inside(std::floor(low.x() - bent), whole.right), inside(std::floor(low.y() - bent), whole.bottom),
          inside(std::ceil(high.x() + bent) + 1.0, whole.right),
          inside(std::ceil(high.y() + bent) + 1.0, whole.bottom)};
}

/// Sets the pixels that the layer can cover, and the motion since its keyframe.
void KeyframeRenderer::prepare(Sheet& sheet, const Eigen::Isometry3d& camera_from_layer) const {
  const Keyframe& key = sheet.keyframe;
  const Eigen::Isometry3d key_from_camera = key.camera_from_layer * camera_from_layer.inverse();
  const bool is_room = sheet.layer.is_room();
  sheet.pixels = is_room ? PixelRect{0, 0, camera_.size.width, camera_.size.height}
                         : pixels_of(key, key_from_camera.inverse());
  if (sheet.pixels.is_empty()) return;

  Eigen::Matrix3d intrinsics = Eigen::Matrix3d::Identity();  // to the middles of the samples
  intrinsics(0, 0) = intrinsics(1, 1) = key_camera_.focal();
  intrinsics(0, 2) = key_camera_.centre_x() - key.drawn.left - 0.5;
  intrinsics(1, 2) = key_camera_.centre_y() - key.drawn.top - 0.5;
  const Eigen::Matrix3d a = intrinsics * key_from_camera.linear();
  const Eigen::Vector3d t = intrinsics * key_from_camera.translation();
  detail::WarpRow& warp = sheet.warp;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column)
      warp.a[static_cast<std::size_t>(3 * row + column)] = static_cast<float>(a(row, column));
    warp.t[static_cast<std::size_t>(row)] = static_cast<float>(t[row]);
  }
  warp.start_1_m = static_cast<float>(key.mean_1_m);
  // Samples that the depth changes.
  const double spread =
      key_camera_.focal() * key_from_camera.translation().norm() * (key.nearest_1_m - key.farthest_1_m);
  constexpr double least_spread = 0.02;
  constexpr double small_spread = 1.0;
  warp.iterations = spread < least_spread ? 0 : spread < small_spread ? 1 : 2;
  if (!is_room) ++warp.iterations;  // the depth orders the layers, and bends at their outlines
  warp.samples = key.samples.data();
  warp.has_cover = !is_room;
  warp.left = key.rect.left - key.drawn.left;  // 0 for the room, and a block of a body is a sample
  warp.top = key.rect.top - key.drawn.top;
  warp.columns = key.rect.columns();
  warp.rows = key.rect.rows();
  warp.inverse_depth_1_m = key.inverse_depth_1_m.data();
  warp.block_columns = key.block_columns;
  warp.block_rows = key.block_rows;
  warp.blocks_per_sample = 1.0F / static_cast<float>(key.block);
}

/// Reprojects the layer's keyframe to the rows [top, bottom).
void KeyframeRenderer::reproject_rows(Sheet& sheet, int top, int bottom, std::span<float> luminance,
                                      Scratch& scratch) const {
  if (sheet.pixels.is_empty()) return;
  const auto left = static_cast<std::size_t>(sheet.pixels.left);
  const auto count = static_cast<std::size_t>(sheet.pixels.right) - left;
  for (int row = std::max(top, sheet.pixels.top); row < std::min(bottom, sheet.pixels.bottom); ++row) {
    const std::size_t first =
        static_cast<std::size_t>(row) * static_cast<std::size_t>(camera_.size.width) + left;
    detail::warp_row(
        sheet.warp, ray_x_.data() + first, ray_y_.data() + first, count,
        {luminance.data() + first, sheet.layer.is_room() ? nullptr : sheet.cover.data() + first,
         sheet.inverse_depth_1_m.data() + first, scratch.u.data(), scratch.v.data(), scratch.at.data()});
  }
}

/// Puts the bodies into the room's image, rows [top, bottom): the nearest fragment of a pixel over the next.
void KeyframeRenderer::compose_rows(std::span<float> luminance, int top, int bottom, Scratch& scratch) const {
  const auto width = static_cast<std::size_t>(camera_.size.width);
  const Sheet& room = sheets_.front();
  for (int y = top; y < bottom; ++y) {
    const std::size_t row = static_cast<std::size_t>(y) * width;
    std::vector<const Sheet*>& bodies = scratch.bodies;
    bodies.clear();
    int left = camera_.size.width;
    int right = 0;
    for (const Sheet& sheet : sheets_) {
      if (sheet.layer.is_room() || !sheet.pixels.has_row(y)) continue;
      bodies.push_back(&sheet);
      left = std::min(left, sheet.pixels.left);
      right = std::max(right, sheet.pixels.right);
    }
    if (bodies.size() == 1) {
      const Sheet& body = *bodies.front();
      const std::size_t first = row + static_cast<std::size_t>(left);
      detail::put_over(
          {body.luminance.data() + first, body.cover.data() + first, body.inverse_depth_1_m.data() + first},
          least_cover, room.inverse_depth_1_m.data() + first, luminance.data() + first,
          static_cast<std::size_t>(right - left));
      continue;
    }
    for (int x = left; x < right; ++x) compose_pixel(x, row + static_cast<std::size_t>(x), bodies, luminance);
  }
}

void KeyframeRenderer::compose_pixel(int x, std::size_t pixel, const std::vector<const Sheet*>& bodies,
                                     std::span<float> luminance) const {
  const Sheet& room = sheets_.front();
  std::array<Fragment, most_fragments> fragments;
  fragments[0] = {luminance[pixel], 1.0F, room.inverse_depth_1_m[pixel]};
  std::size_t count = 1;
  for (const Sheet* const sheet : bodies) {
    if (x < sheet->pixels.left || x >= sheet->pixels.right || !(sheet->cover[pixel] > least_cover)) continue;
    const Fragment fragment{sheet->luminance[pixel], sheet->cover[pixel], sheet->inverse_depth_1_m[pixel]};
    std::size_t at = std::min(count, most_fragments - 1);
    if (count == most_fragments && fragments[at].inverse_depth_1_m >= fragment.inverse_depth_1_m) continue;
    for (; at > 0 && fragments[at - 1].inverse_depth_1_m < fragment.inverse_depth_1_m; --at)
      fragments[at] = fragments[at - 1];
    fragments[at] = fragment;
    count = std::min(count + 1, most_fragments);
  }
  if (count < 2) return;
  float through = 1.0F;
  float sum = 0.0F;
  for (std::size_t i = 0; i < count; ++i) {
    sum += through * fragments[i].luminance;
    through *= 1.0F - std::min(fragments[i].cover, 1.0F);
  }
  luminance[pixel] = sum;
}

double KeyframeRenderer::visible_share(const Eigen::Vector3d& centre_m, double radius_m, int body) {
  const double depth2 = centre_m.z() * centre_m.z() - radius_m * radius_m;
  if (!(centre_m.z() > radius_m) || !(depth2 > 0.0)) return 0.0;
  const double k = centre_m.squaredNorm() - radius_m * radius_m;
  // The outline is an ellipse with the semi-axes R sqrt(k) / depth2 and R / sqrt(depth2) at unit depth.
  const double area = std::numbers::pi * radius_m * radius_m * std::sqrt(k) / (depth2 * std::sqrt(depth2));
  const auto own =
      std::ranges::find_if(sheets_, [&](const Sheet& sheet) { return sheet.layer.body == body; });
  if (own == sheets_.end() || own->pixels.is_empty()) return 0.0;
  const auto rows = static_cast<std::size_t>(own->pixels.bottom - own->pixels.top);
  const auto columns = static_cast<std::size_t>(own->pixels.right - own->pixels.left);
  shares_.resize(rows * columns);
  constexpr std::size_t small_rows = 64;  // one thread alone is done sooner
  const std::size_t parts = rows > small_rows ? scratch_.size() : 1;
  threads_->run(parts, [&](std::size_t part) {
    for (std::size_t row = part; row < rows; row += parts) {
      for (std::size_t column = 0; column < columns; ++column)
        shares_[row * columns + column] =
            share_of_pixel(*own, own->pixels.left + static_cast<int>(column),
                           own->pixels.top + static_cast<int>(row), centre_m, k);
    }
  });
  double all = 0.0;
  double visible = 0.0;
  for (const Share& share : shares_) {
    all += share.all;
    visible += share.visible;
  }
  constexpr double close_share = 0.98;  // samples of a disc miss its area by less than that
  return visible / (all > close_share * area ? all : area);
}

/// What a pixel shows of a sphere's disc, and what of it nothing else hides; areas at unit depth. `k`: the square of the length of
/// the sphere's tangents.
KeyframeRenderer::Share KeyframeRenderer::share_of_pixel(const Sheet& own, int column, int row,
                                                         const Eigen::Vector3d& centre_m, double k) const {
  constexpr std::array<float, 2> places{-0.25F, 0.25F};  // of a pixel's samples
  const auto pixel = static_cast<std::size_t>(row) * static_cast<std::size_t>(camera_.size.width) +
                     static_cast<std::size_t>(column);
  const std::array<float, 4>& slope = ray_slope_[pixel];
  int inside = 0;
  double nearest_1_m = 0.0;
  for (const float right : places) {
    for (const float down : places) {
      const auto x = static_cast<double>(ray_x_[pixel] + right * slope[0] + down * slope[2]);
      const auto y = static_cast<double>(ray_y_[pixel] + right * slope[1] + down * slope[3]);
      const double along = centre_m.x() * x + centre_m.y() * y + centre_m.z();
      const double ray2 = x * x + y * y + 1.0;
      const double root2 = along * along - ray2 * k;
      if (root2 < 0.0) continue;
      ++inside;
      nearest_1_m = std::max(nearest_1_m, ray2 / (along - std::sqrt(root2)));
    }
  }
  if (inside == 0) return {};
  const double hides_1_m = 1.0 / (1.0 / nearest_1_m - EyeRenderer::hidden_by_m);
  double through = 1.0;
  for (const Sheet& sheet : sheets_) {
    if (&sheet == &own || !sheet.pixels.holds(column, row)) continue;
    if (static_cast<double>(sheet.inverse_depth_1_m[pixel]) < hides_1_m) continue;
    through *= sheet.layer.is_room() ? 0.0 : 1.0 - static_cast<double>(std::min(1.0F, sheet.cover[pixel]));
  }
  const double part = std::abs(static_cast<double>(slope[0] * slope[3] - slope[1] * slope[2])) * inside /
                      static_cast<double>(places.size() * places.size());
  return {part, part * through};
}

}  // namespace saccade
