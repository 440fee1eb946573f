#include "sim/renderer.h"

#include <GL/gl.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "core/error.h"

namespace saccade {
namespace detail {

/// MuJoCo's abstract scene and its OpenGL resources, with the frame buffer to draw into.
class SceneDrawer {
 public:
  /// What costs time and is not needed in an eye.
  enum class Quality { fast, fine };

  SceneDrawer(const mjModel& model, GlContext& gl, ImageSize buffer, Quality quality)
      : model_(model), quality_(quality) {
    gl.make_current();
    // A shallow copy whose visual settings are ours, whatever the MJCF says.
    mjModel settings = model;
    settings.vis.global.offwidth = buffer.width;
    settings.vis.global.offheight = buffer.height;
    const bool fine = quality == Quality::fine;
    settings.vis.quality.offsamples = fine ? 4 : 0;
    settings.vis.quality.shadowsize = 0;
    // A triangle costs 60 ns in software: hands and pots are coarse in an eye, only the ball is not.
    settings.vis.quality.numslices = fine ? 32 : 10;
    settings.vis.quality.numstacks = fine ? 16 : 4;
    settings.vis.quality.numquads = fine ? 8 : 1;
    mjv_defaultOption(&option_);
    mjv_defaultScene(&scene_);
    mjr_defaultContext(&context_);
    mjv_makeScene(&settings, &scene_, static_cast<int>(model.ngeom) + 100);
    mjr_makeContext(&settings, &context_, mjFONTSCALE_50);
    mjr_setBuffer(mjFB_OFFSCREEN, &context_);
    if (context_.currentBuffer != mjFB_OFFSCREEN || context_.offWidth < buffer.width) {
      throw RunError("OpenGL failed: no offscreen buffer");
    }
    read_pixels_ = function<decltype(glReadPixels)>(gl, "glReadPixels");
    if (!fine) {
      compile_sphere(gl);
      leave_out_mipmaps(gl);
    }
    std::fill(std::begin(scene_.flags), std::end(scene_.flags), mjtByte{0});
    scene_.flags[mjRND_CULL_FACE] = 1;
    for (int group = 0; group < mjNGROUP; ++group) option_.geomgroup[group] = group < (fine ? 3 : 2) ? 1 : 0;
  }
  ~SceneDrawer() {
    mjr_freeContext(&context_);
    mjv_freeScene(&scene_);
  }
  SceneDrawer(const SceneDrawer&) = delete;
  SceneDrawer& operator=(const SceneDrawer&) = delete;

  /// Lit and painted; or, where `number_of_geom` is given, each geom flat in the colour (number, 0, 0).
  void draw(mjData& data, const mjvGLCamera& camera, mjrRect viewport,
            std::span<const std::uint8_t> number_of_geom = {}, std::span<const SceneMark> marks = {}) {
    update(data);
    for (const SceneMark& mark : marks) add(mark);
    const bool numbered = !number_of_geom.empty();
    scene_.flags[mjRND_SEGMENT] = scene_.flags[mjRND_IDCOLOR] = numbered ? 1 : 0;
    if (numbered) {
      for (mjvGeom& geom : drawn()) geom.segid = number_of_geom[static_cast<std::size_t>(geom.objid)] - 1;
    }
    if (quality_ == Quality::fast) {
      refine_spheres();
      leave_out_unseen(camera, viewport);
    }
    mjr_restoreBuffer(&context_);  // another drawer may have drawn meanwhile
    scene_.camera[0] = scene_.camera[1] = camera;
    mjr_render(viewport, &scene_, &context_);
  }
  void read_rgba(mjrRect area, std::uint32_t* rgba) const {
    mjr_restoreBuffer(&context_);
    read_pixels_(area.left, area.bottom, area.width, area.height, GL_RGBA, GL_UNSIGNED_BYTE, rgba);
  }
  void read_rgb(mjrRect area, std::uint8_t* rgb) const { mjr_readPixels(rgb, nullptr, area, &context_); }
  /// 0 at the near plane, 1 at the far plane, as OpenGL has it by default.
  void read_depth(mjrRect area, float* depth) const {
    mjr_restoreBuffer(&context_);
    mjr_readPixels(nullptr, depth, area, &context_);
  }

 private:
  /// Of the outline of a sphere in an eye. Seen from the side its outline runs through stacks, from above
  /// through slices: there are half as many stacks.
  static constexpr int sphere_sides = 40;

  template <class Function>
  static Function* function(GlContext& gl, const char* name) {
    void* address = gl.function(name);
    if (address == nullptr) throw RunError(std::string("OpenGL failed: no ") + name);
    return reinterpret_cast<Function*>(address);
  }

  /// Replaces MuJoCo's sphere, the first of its builtin display lists, by a finer one.
  void compile_sphere(GlContext& gl) const {
    auto* const begin = function<decltype(glBegin)>(gl, "glBegin");
    auto* const end = function<decltype(glEnd)>(gl, "glEnd");
    auto* const normal = function<decltype(glNormal3d)>(gl, "glNormal3d");
    auto* const vertex = function<decltype(glVertex3d)>(gl, "glVertex3d");
    const auto corner = [&](int stack, int slice) {
      const double polar = 2.0 * std::numbers::pi * stack / sphere_sides;
      const double around = 2.0 * std::numbers::pi * slice / sphere_sides;
      const double x = std::sin(polar) * std::cos(around);
      const double y = std::sin(polar) * std::sin(around);
      normal(x, y, std::cos(polar));
      vertex(x, y, std::cos(polar));
    };
    function<decltype(glNewList)>(gl, "glNewList")(context_.baseBuiltin, GL_COMPILE);
    begin(GL_QUADS);
    for (int stack = 0; stack < sphere_sides / 2; ++stack) {
      for (int slice = 0; slice < sphere_sides; ++slice) {
        corner(stack, slice);
        corner(stack + 1, slice);
        corner(stack + 1, slice + 1);
        corner(stack, slice + 1);
      }
    }
    end();
    function<decltype(glEndList)>(gl, "glEndList")();
  }

  /// The lab's texels are about as large as samples: without mipmaps 2 x 2 samples come nearer to the true
  /// mean of a pixel, and cost a third less.
  void leave_out_mipmaps(GlContext& gl) const {
    auto* const bind = function<decltype(glBindTexture)>(gl, "glBindTexture");
    auto* const set = function<decltype(glTexParameteri)>(gl, "glTexParameteri");
    for (int i = 0; i < context_.ntexture; ++i) {
      const GLenum target = context_.textureType[i] == mjTEXTURE_2D ? GL_TEXTURE_2D : GL_TEXTURE_CUBE_MAP;
      bind(target, context_.texture[i]);
      set(target, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
      bind(target, 0);
    }
  }

  void update(mjData& data) {
    scene_.ngeom = 0;
    mjv_addGeoms(&model_, &data, &option_, nullptr, mjCAT_STATIC | mjCAT_DYNAMIC, &scene_);
    scene_.nlight = 0;
    mjv_makeLights(&model_, &data, &scene_);
    // What does not stand in the room is nearest: drawn first, it spares the pixels behind it.
    const std::span geoms = drawn();
    std::stable_partition(geoms.begin(), geoms.end(),
                          [this](const mjvGeom& geom) { return model_.geom_bodyid[geom.objid] != 0; });
  }

  void add(const SceneMark& mark) {
    SACCADE_CHECK(scene_.ngeom < scene_.maxgeom);
    const Eigen::Vector3d along = mark.to_m - mark.from_m;
    const Eigen::Vector3d middle = 0.5 * (mark.from_m + mark.to_m);
    const std::array<mjtNum, 3> size = {mark.radius_m, 0.5 * along.norm(), 0.0};
    using RowMajor = Eigen::Matrix<mjtNum, 3, 3, Eigen::RowMajor>;
    const RowMajor turn =
        Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), along).toRotationMatrix();
    mjvGeom& geom = scene_.geoms[scene_.ngeom++];
    mjv_initGeom(&geom, mjGEOM_CAPSULE, size.data(), middle.data(), turn.data(), mark.rgba.data());
    geom.emission = 1.0F;
  }

  std::span<mjvGeom> drawn() { return {scene_.geoms, static_cast<std::size_t>(scene_.ngeom)}; }

  /// A regular polygon of n sides has the area of its circumscribed circle times 1 - (2 pi / n)^2 / 6.
  void refine_spheres() {
    constexpr double step = 2.0 * std::numbers::pi / sphere_sides;
    constexpr auto same_area = static_cast<float>(1.0 + step * step / 12.0);
    for (mjvGeom& geom : drawn()) {
      if (geom.type != mjGEOM_SPHERE) continue;
      for (float& size : geom.size) size *= same_area;
    }
  }

  /// Every geom costs some microseconds even when no pixel of it is in the image.
  void leave_out_unseen(const mjvGLCamera& camera, mjrRect viewport) {
    using Eigen::Vector3f;
    const Vector3f position(camera.pos);
    const Vector3f forward(camera.forward);
    const Vector3f up(camera.up);
    const Vector3f right = forward.cross(up);
    const float half_width = 0.5F * (camera.frustum_top - camera.frustum_bottom) *
                             static_cast<float>(viewport.width) / static_cast<float>(viewport.height);
    const float near = camera.frustum_near;
    // Normals of the frustum's sides, pointing out.
    const std::array<Vector3f, 4> sides{
        (near * right - (camera.frustum_center + half_width) * forward).normalized(),
        (-near * right + (camera.frustum_center - half_width) * forward).normalized(),
        (near * up - camera.frustum_top * forward).normalized(),
        (-near * up + camera.frustum_bottom * forward).normalized()};
    const std::span geoms = drawn();
    const auto unseen = [&](const mjvGeom& geom) {
      const float reach = geom.modelrbound;
      if (!(reach > 0.0F)) return false;  // endless
      const Vector3f from_eye = Vector3f(geom.pos) - position;
      return std::any_of(sides.begin(), sides.end(),
                         [&](const Vector3f& out) { return out.dot(from_eye) > 1.01F * reach; });
    };
    scene_.ngeom = static_cast<int>(std::remove_if(geoms.begin(), geoms.end(), unseen) - geoms.begin());
  }

  const mjModel& model_;
  Quality quality_;
  mjvOption option_{};
  mjvScene scene_{};
  mjrContext context_{};
  decltype(glReadPixels)* read_pixels_ = nullptr;
};

}  // namespace detail

namespace {

using detail::SceneDrawer;

// Rec. 709 luminance of linear red, green and blue, in 1/10000.
constexpr std::uint32_t red_weight = 2126;
constexpr std::uint32_t green_weight = 7152;
constexpr std::uint32_t blue_weight = 722;
constexpr double hidden_by_m = 0.003;

/// The samples [first, last) along one image axis that the outline of a sphere spans: its tangent planes
/// through the other axis meet z = 1 at u with (dx - u dz)^2 = R^2 (1 + u^2).
std::array<int, 2> outline_span(double dx, double dz, double radius, double focal, double centre) {
  const double r2 = radius * radius;
  const double root = radius * std::sqrt(std::max(dx * dx + dz * dz - r2, 0.0));
  const double scale = focal / (dz * dz - r2);
  return {static_cast<int>(std::floor(centre + scale * (dx * dz - root))),
          static_cast<int>(std::ceil(centre + scale * (dx * dz + root)))};
}

/// A convex polygon of few corners.
struct Polygon {
  std::array<Eigen::Vector2d, 8> corners;
  std::size_t count = 0;

  void add(const Eigen::Vector2d& corner) { corners.at(count++) = corner; }
  /// The part where sign * (coordinate - bound) >= 0.
  [[nodiscard]] Polygon clipped(Eigen::Index axis, double bound, double sign) const {
    Polygon part;
    for (std::size_t i = 0; i < count; ++i) {
      const Eigen::Vector2d& from = corners.at(i);
      const Eigen::Vector2d& to = corners.at((i + 1) % count);
      const double begin = sign * (from[axis] - bound);
      const double end = sign * (to[axis] - bound);
      if (begin >= 0.0) part.add(from);
      if ((begin < 0.0) != (end < 0.0)) part.add(from + (to - from) * (begin / (begin - end)));
    }
    return part;
  }
  [[nodiscard]] double area() const {
    double twice = 0.0;
    for (std::size_t i = 1; i + 1 < count; ++i) {
      const Eigen::Vector2d a = corners.at(i) - corners[0];
      const Eigen::Vector2d b = corners.at(i + 1) - corners[0];
      twice += a.x() * b.y() - a.y() * b.x();
    }
    return 0.5 * std::abs(twice);
  }
  [[nodiscard]] std::array<int, 2> span(Eigen::Index axis) const {
    double low = corners[0][axis];
    double high = low;
    for (std::size_t i = 1; i < count; ++i) {
      low = std::min(low, corners.at(i)[axis]);
      high = std::max(high, corners.at(i)[axis]);
    }
    return {static_cast<int>(std::floor(low)), static_cast<int>(std::ceil(high))};
  }
};

}  // namespace

void describe(FieldVisitor& v, EyeRenderConfig& config) {
  v.integer("supersampling", config.supersampling, {1, 8}, "samples per pixel and direction");
  v.real("near_m", config.near_m, {0.001, 0.2}, "nothing nearer along the optical axis is drawn");
  v.real("far_m", config.far_m, {1.0, 1000.0}, "nothing farther along the optical axis is drawn");
}

EyeRenderer::EyeRenderer(const mjModel& model, GlContext& gl, const Camera& camera,
                         const EyeRenderConfig& config)
    : camera_(camera), config_(config), gl_(gl) {
  check_config("render", config);
  check_config("camera", camera);
  const double stretch = camera.fy_px / camera.fx_px;
  if (!(stretch > 0.5 && stretch < 2.0)) {
    throw InputError("camera.fx_px", text_of(camera.fx_px), "between fy / 2 and 2 fy");
  }
  focal_ = static_cast<double>(config.supersampling) * camera.fy_px;
  gather_samples();
  drawer_ = std::make_unique<SceneDrawer>(model, gl, ImageSize{columns_, rows_}, SceneDrawer::Quality::fast);
}

void EyeRenderer::gather_samples() {
  const auto width = static_cast<std::size_t>(camera_.size.width);
  const auto height = static_cast<std::size_t>(camera_.size.height);
  // Where the corners of the pixels are in the drawn image.
  std::vector<Eigen::Vector2d> corners;
  corners.reserve((width + 1) * (height + 1));
  Eigen::Vector2d low = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector2d high = -low;
  for (std::size_t y = 0; y <= height; ++y) {
    for (std::size_t x = 0; x <= width; ++x) {
      const Eigen::Vector3d ray = camera_.ray(static_cast<double>(x) - 0.5, static_cast<double>(y) - 0.5);
      corners.emplace_back(focal_ * ray.head<2>());
      low = low.cwiseMin(corners.back());
      high = high.cwiseMax(corners.back());
    }
  }
  for (Eigen::Vector2d& corner : corners) corner -= low;
  constexpr double rounding = 1e-9;
  columns_ = static_cast<int>(std::ceil(high.x() - low.x() - rounding));
  rows_ = static_cast<int>(std::ceil(high.y() - low.y() - rounding));
  centre_x_ = -low.x();
  centre_y_ = -low.y();

  const auto columns = static_cast<std::size_t>(columns_);
  const std::size_t drawn = columns * static_cast<std::size_t>(rows_);
  std::vector<double> covered(drawn, 0.0);  // of each sample by all pixels
  for (std::size_t pixel = 0; pixel < width * height; ++pixel) {
    const std::size_t corner = pixel + pixel / width;
    Polygon footprint;
    for (const std::size_t i : {corner, corner + 1, corner + width + 2, corner + width + 1}) {
      footprint.add(corners[i]);
    }
    const double share = 1.0 / (footprint.area() * 10000.0);
    const auto [top, bottom] = footprint.span(1);
    for (int row = top; row < std::min(bottom, rows_); ++row) {
      const Polygon strip = footprint.clipped(1, row, 1.0).clipped(1, row + 1, -1.0);
      if (strip.area() < rounding) continue;
      const auto [left, right] = strip.span(0);
      for (int column = left; column < std::min(right, columns_); ++column) {
        const double area = strip.clipped(0, column, 1.0).clipped(0, column + 1, -1.0).area();
        const int in_group = (column - left) % 4;
        const std::size_t sample =
            static_cast<std::size_t>(rows_ - 1 - row) * columns + static_cast<std::size_t>(column);
        if (in_group == 0) samples_.push_back({static_cast<std::uint32_t>(sample), {}});
        samples_.back().weights.at(static_cast<std::size_t>(in_group)) = static_cast<float>(area * share);
        covered[sample] += area;
      }
    }
    samples_end_.push_back(static_cast<std::uint32_t>(samples_.size()));
  }
  is_inside_.resize(drawn);
  std::ranges::transform(covered, is_inside_.begin(), [](double area) { return area >= 0.5 ? 1 : 0; });
  rgba_.resize(drawn);
  drawn_.assign(drawn + 3, 0.0F);  // four at a time, past the end too
}

EyeRenderer::~EyeRenderer() { gl_.make_current(); }

void EyeRenderer::render(mjData& data, int camera_id, std::span<float> luminance) {
  SACCADE_CHECK(luminance.size() == static_cast<std::size_t>(camera_.size.pixels()));
  draw(data, camera_id, Eigen::Vector2d::Zero());
  resample<red_weight, green_weight, blue_weight>(luminance);
}

void EyeRenderer::render_colour(mjData& data, int camera_id, const Eigen::Vector2d& shift_px,
                                std::span<float> rgb) {
  const auto pixels = static_cast<std::size_t>(camera_.size.pixels());
  SACCADE_CHECK(rgb.size() == 3 * pixels);
  draw(data, camera_id, shift_px);
  resample<10000, 0, 0>(rgb.first(pixels));
  resample<0, 10000, 0>(rgb.subspan(pixels, pixels));
  resample<0, 0, 10000>(rgb.last(pixels));
}

void EyeRenderer::label(mjData& data, int camera_id, std::span<const std::uint8_t> number_of_geom,
                        std::uint8_t nothing, std::span<std::uint8_t> numbers) {
  SACCADE_CHECK(numbers.size() == static_cast<std::size_t>(camera_.size.pixels()));
  draw(data, camera_id, Eigen::Vector2d::Zero(), number_of_geom);
  const Samples* samples = samples_.data();
  for (std::size_t pixel = 0; pixel < numbers.size(); ++pixel) {
    std::uint32_t smallest = 255;
    for (const Samples* end = samples_.data() + samples_end_[pixel]; samples != end; ++samples) {
      for (std::size_t i = 0; i < 4; ++i) {
        if (!(samples->weights[i] > 0.0F)) continue;
        const std::uint32_t number = rgba_[samples->first + i] & 0xffU;
        if (number > 0) smallest = std::min(smallest, number);
      }
    }
    numbers[pixel] = smallest == 255 ? nothing : static_cast<std::uint8_t>(smallest);
  }
}

void EyeRenderer::draw(mjData& data, int camera_id, const Eigen::Vector2d& shift_px,
                       std::span<const std::uint8_t> number_of_geom) {
  const mjtNum* position = data.cam_xpos + 3 * camera_id;
  const mjtNum* axes = data.cam_xmat + 9 * camera_id;
  mjvGLCamera eye{};
  for (int i = 0; i < 3; ++i) {
    eye.pos[i] = static_cast<float>(position[i]);
    eye.forward[i] = static_cast<float>(-axes[3 * i + 2]);
    eye.up[i] = static_cast<float>(axes[3 * i + 1]);
  }
  const double per_sample = config_.near_m / focal_;
  const double centre_x = centre_x_ - shift_px.x() * focal_ / camera_.fx_px;
  const double centre_y = centre_y_ - shift_px.y() * focal_ / camera_.fy_px;
  eye.frustum_center = static_cast<float>(per_sample * (0.5 * columns_ - centre_x));
  eye.frustum_top = static_cast<float>(per_sample * centre_y);
  eye.frustum_bottom = static_cast<float>(per_sample * (centre_y - rows_));
  eye.frustum_near = static_cast<float>(config_.near_m);
  eye.frustum_far = static_cast<float>(config_.far_m);

  gl_.make_current();
  const mjrRect whole{0, 0, columns_, rows_};
  drawer_->draw(data, eye, whole, number_of_geom);
  drawer_->read_rgba(whole, rgba_.data());
}

template <std::uint32_t red, std::uint32_t green, std::uint32_t blue>
void EyeRenderer::resample(std::span<float> image) {
  for (std::size_t i = 0; i < rgba_.size(); ++i) {
    const std::uint32_t rgba = rgba_[i];
    // Signed, because that is what SSE converts.
    drawn_[i] = static_cast<float>(static_cast<std::int32_t>(
        red * (rgba & 0xffU) + green * ((rgba >> 8U) & 0xffU) + blue * ((rgba >> 16U) & 0xffU)));
  }
  const Samples* samples = samples_.data();
  for (std::size_t pixel = 0; pixel < image.size(); ++pixel) {
    std::array<float, 4> sums{};
    for (const Samples* end = samples_.data() + samples_end_[pixel]; samples != end; ++samples) {
      const float* from = drawn_.data() + samples->first;
      for (std::size_t i = 0; i < 4; ++i) sums[i] += samples->weights[i] * from[i];
    }
    image[pixel] = (sums[0] + sums[1]) + (sums[2] + sums[3]);
  }
}

double EyeRenderer::visible_share(const Eigen::Vector3d& centre_m, double radius_m) {
  if (!(centre_m.z() > radius_m)) return 0.0;
  const auto [left, right] = outline_span(centre_m.x(), centre_m.z(), radius_m, focal_, centre_x_);
  const auto [top, bottom] = outline_span(centre_m.y(), centre_m.z(), radius_m, focal_, centre_y_);
  const mjrRect seen{std::max(left, 0), rows_ - std::min(bottom, rows_),
                     std::min(right, columns_) - std::max(left, 0),
                     std::min(bottom, rows_) - std::max(top, 0)};
  if (seen.width <= 0 || seen.height <= 0) return 0.0;
  depth_.resize(static_cast<std::size_t>(seen.width) * static_cast<std::size_t>(seen.height));
  gl_.make_current();
  drawer_->read_depth(seen, depth_.data());

  const double k = centre_m.squaredNorm() - radius_m * radius_m;
  const double span = config_.far_m - config_.near_m;
  std::int64_t all = 0;
  std::int64_t visible = 0;
  for (int row = top; row < bottom; ++row) {
    const double ray_y = (row + 0.5 - centre_y_) / focal_;
    const bool row_inside = row >= 0 && row < rows_;
    const std::uint8_t* is_inside_row =
        is_inside_.data() + static_cast<std::ptrdiff_t>(rows_ - 1 - row) * columns_;
    const float* depth_row =
        depth_.data() + static_cast<std::ptrdiff_t>(rows_ - 1 - row - seen.bottom) * seen.width - seen.left;
    for (int column = left; column < right; ++column) {
      const double ray_x = (column + 0.5 - centre_x_) / focal_;
      const double along = centre_m.x() * ray_x + centre_m.y() * ray_y + centre_m.z();
      const double ray2 = ray_x * ray_x + ray_y * ray_y + 1.0;
      const double root2 = along * along - ray2 * k;
      if (root2 < 0.0) continue;
      ++all;
      if (!row_inside || column < 0 || column >= columns_ || is_inside_row[column] == 0) continue;
      const double drawn_m =
          config_.near_m * config_.far_m / (config_.far_m - static_cast<double>(depth_row[column]) * span);
      if (drawn_m > (along - std::sqrt(root2)) / ray2 - hidden_by_m) ++visible;
    }
  }
  return all == 0 ? 0.0 : static_cast<double>(visible) / static_cast<double>(all);
}

SceneView profile_view() {
  SceneView view;
  view.look_at_m = {-0.32, 0.0, 0.27};
  view.distance_m = 1.15;
  view.azimuth_rad = 95.0 * std::numbers::pi / 180.0;
  view.elevation_rad = -0.12;
  return view;
}

SceneRenderer::SceneRenderer(const mjModel& model, GlContext& gl, ImageSize size) : size_(size), gl_(gl) {
  if (size.width < 8 || size.height < 8 || size.width > 4096 || size.height > 4096) {
    throw InputError("picture size", std::to_string(size.width) + "x" + std::to_string(size.height),
                     "8x8 to 4096x4096");
  }
  drawer_ = std::make_unique<SceneDrawer>(model, gl, size, SceneDrawer::Quality::fine);
}

SceneRenderer::~SceneRenderer() { gl_.make_current(); }

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

  gl_.make_current();
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
      const double linear = static_cast<double>(i) / 255.0;
      const double srgb = linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055;
      table[i] = static_cast<std::uint8_t>(std::lround(255.0 * srgb));
    }
    return table;
  }();
  for (std::uint8_t& value : rgb) value = srgb_of_linear[value];
}

}  // namespace saccade
