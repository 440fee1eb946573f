#include "config/cameras.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/units.h"
#include "head/icub_cameras.h"

namespace saccade {
namespace {

constexpr const char* pinhole = "pinhole";

/// A sensor behind a lens without distortion, its optical axis through the middle of the image.
CameraPreset nominal(const char* name, ImageSize size, double pixel_pitch_um, double focal_mm) {
  Camera camera = pinhole_camera(size);
  camera.fx_px = camera.fy_px = 1e3 * focal_mm / pixel_pitch_um;
  return {name, camera, pixel_pitch_um, name, true};
}

std::vector<CameraPreset> make_presets() {
  constexpr double dvs128_um = 40.0;
  constexpr double davis_um = 18.5;
  const Camera davis240{.size = {240, 180},
                        .fx_px = 199.092,
                        .fy_px = 198.829,
                        .cx_px = 132.192,
                        .cy_px = 110.713,
                        .k1 = -0.368436,
                        .k2 = 0.150947,
                        .p1 = -0.000296131,
                        .p2 = -0.000759432};
  const Camera davis346{.size = {346, 260},
                        .fx_px = 226.380,
                        .fy_px = 226.150,
                        .cx_px = 173.647,
                        .cy_px = 133.733,
                        .k1 = -0.0480314,
                        .k2 = 0.0113310,
                        .p1 = 0.0,
                        .p2 = 0.0,
                        .lens = LensModel::fisheye,
                        .k3 = -0.0553782,
                        .k4 = 0.0215010};
  return {{"icub_left_2016", icub_left_2016, dvs128_um, "", false},
          {"icub_right_2016", icub_right_2016, dvs128_um, "", false},
          {pinhole, pinhole_camera(icub_left_2016.size), 0.0, "", false},
          nominal("dvs128", {128, 128}, dvs128_um, 4.0),
          {"davis240", davis240, davis_um, "davis240", true},
          {"davis346", davis346, davis_um, "davis346", true},
          nominal("gen3_vga", {640, 480}, 15.0, 8.0),
          nominal("gen4_hd", {1280, 720}, 4.86, 5.0)};
}

/// What stands for the focal length, and the focal length that follows, px.
struct FocalKey {
  const char* key;
  double value;
  double focal_px;
};

/// Focal lengths that differ by more contradict each other.
constexpr double agree = 0.01;

/// Keys that stand for others; a reader alone has them.
struct Alternatives {
  std::optional<double> pixel_pitch_um, focal_mm, field_of_view_deg;

  [[nodiscard]] bool any() const { return focal_mm || field_of_view_deg; }
};

Alternatives describe_alternatives(FieldVisitor& v) {
  Alternatives given;
  given.pixel_pitch_um =
      v.alternative("pixel_pitch_um", {0.5, 200.0}, "distance of two pixels, for focal_mm; of the preset");
  given.focal_mm = v.alternative("focal_mm", {0.5, 500.0},
                                 "focal length in place of fx_px and fy_px; a lens without distortion");
  given.field_of_view_deg =
      v.alternative("field_of_view_deg", {1.0, 179.0},
                    "angle from left to right in place of fx_px and fy_px; a lens without distortion");
  return given;
}

/// Sets the focal lengths from what was given; fx_px and fy_px are NaN where the file has none.
void resolve_focal(FieldVisitor& v, Camera& camera, const Camera& preset, const Alternatives& given,
                   double preset_pitch_um) {
  std::vector<FocalKey> keys;
  for (const auto& [key, value] : {std::pair{"fx_px", camera.fx_px}, {"fy_px", camera.fy_px}}) {
    if (std::isfinite(value)) keys.push_back({key, value, value});
  }
  const bool direct = !keys.empty();
  if (given.focal_mm) {
    const double pitch_um = given.pixel_pitch_um.value_or(preset_pitch_um);
    v.require(pitch_um > 0.0, "focal_mm", text_of(*given.focal_mm),
              "pixel_pitch_um beside it, or a preset that has one");
    if (pitch_um > 0.0) keys.push_back({"focal_mm", *given.focal_mm, 1e3 * *given.focal_mm / pitch_um});
  }
  v.require(!given.pixel_pitch_um || given.focal_mm, "pixel_pitch_um",
            text_of(given.pixel_pitch_um.value_or(0.0)), "focal_mm beside it, the one key that it changes");
  if (given.field_of_view_deg) {
    const double focal_px = focal_px_of_view(camera, camera.size.width, *given.field_of_view_deg);
    v.require(std::isfinite(focal_px), "field_of_view_deg", text_of(*given.field_of_view_deg),
              "a field of view that the lens k1, k2 has");
    keys.push_back({"field_of_view_deg", *given.field_of_view_deg, focal_px});
  }
  const double fx_px = camera.fx_px;
  const double fy_px = camera.fy_px;
  camera.fx_px = std::isfinite(fx_px) ? fx_px : preset.fx_px;
  camera.fy_px = std::isfinite(fy_px) ? fy_px : preset.fy_px;
  if (!given.any()) return;
  for (std::size_t i = 1; i < keys.size(); ++i) {
    const bool both_direct = std::string_view(keys[i].key) == "fy_px";  // pixels need not be square
    const double ratio = keys[i].focal_px / keys[0].focal_px;
    v.require(
        both_direct || std::abs(ratio - 1.0) <= agree, keys[i].key,
        text_of(keys[i].value) + " (a focal length of " + text_of(std::round(keys[i].focal_px)) + " px)",
        std::string("what ") + keys[0].key + ": " + text_of(keys[0].value) + " says, " +
            text_of(std::round(keys[0].focal_px)) + " px, or one of the two keys alone");
  }
  if (keys.empty()) return;
  const double focal_px = keys.back().focal_px;
  if (!std::isfinite(fx_px)) camera.fx_px = direct ? fy_px : focal_px;
  if (!std::isfinite(fy_px)) camera.fy_px = direct ? fx_px : focal_px;
}

}  // namespace

const std::vector<CameraPreset>& camera_preset_rows() {
  static const std::vector<CameraPreset> rows = make_presets();
  return rows;
}

const std::vector<std::string>& camera_presets() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const CameraPreset& row : camera_preset_rows()) all.push_back(row.name);
    return all;
  }();
  return names;
}

const CameraPreset& camera_preset_row(const std::string& name) {
  for (const CameraPreset& row : camera_preset_rows()) {
    if (row.name == name) return row;
  }
  throw InputError("camera.preset", name, expectation_of(camera_presets()));
}

Camera camera_preset(const std::string& name) { return camera_preset_row(name).camera; }

Camera pinhole_camera(ImageSize size) {
  constexpr double focal_per_width = 0.777;
  Camera camera;
  camera.size = size;
  camera.fx_px = camera.fy_px = focal_per_width * size.width;
  camera.cx_px = 0.5 * (size.width - 1);
  camera.cy_px = 0.5 * (size.height - 1);
  return camera;
}

double field_of_view_deg(const Camera& camera) {
  const Eigen::Vector3d left = camera.ray(-0.5, camera.cy_px);
  const Eigen::Vector3d right = camera.ray(camera.size.width - 0.5, camera.cy_px);
  return deg_per_rad * std::acos(std::clamp(left.normalized().dot(right.normalized()), -1.0, 1.0));
}

double focal_px_of_view(const Camera& camera, double width_px, double deg) {
  Camera unit = camera;
  unit.fx_px = unit.fy_px = 1.0;
  unit.cx_px = unit.cy_px = 0.0;
  const auto border = unit.project({std::tan(0.5 * deg * rad_per_deg), 0.0, 1.0});
  return border ? 0.5 * width_px / border->x() : std::numeric_limits<double>::quiet_NaN();
}

void describe_camera(FieldVisitor& v, MountedCamera& mounted, std::string& preset,
                     const CameraDefault& by_default) {
  Camera& camera = mounted.camera;
  const bool reads = v.fills_defaults();
  if (reads) preset.clear();
  v.choice(
      "preset", preset, camera_presets(),
      "camera whose values are the defaults of the keys below; pinhole where an image size is given alone");
  const bool chosen = !preset.empty();
  if (!chosen) preset = by_default.preset;
  if (reads) {
    camera = camera_preset(preset);
    if (!chosen && camera.size != by_default.size) camera = pinhole_camera(by_default.size);
    if (!chosen && by_default.camera) camera = *by_default.camera;
  }
  const ImageSize size = camera.size;
  describe_image_size(v, camera);
  if (reads && camera.size != size && (!chosen || preset == pinhole)) camera = pinhole_camera(camera.size);
  if (reads && !chosen && camera.size != camera_preset(preset).size) preset = pinhole;
  const CameraPreset& row = camera_preset_row(preset);
  const ImageSize image = row.camera.size;
  const bool region =
      row.has_regions && camera.size.width <= image.width && camera.size.height <= image.height;
  v.require(preset == pinhole || camera.size == image || region, "width_px", in_words(camera.size),
            (row.has_regions ? "at most " : "") + in_words(image) + ", the image of the preset " + preset +
                "; without a preset any size");
  if (reads && chosen && region) {
    camera.cx_px -= 0.5 * (image.width - camera.size.width);
    camera.cy_px -= 0.5 * (image.height - camera.size.height);
  }
  const Alternatives given = describe_alternatives(v);
  const Camera start = camera;
  if (reads) {
    if (given.any()) {
      camera = camera.without_distortion();
      camera.lens = start.lens;
    }
    camera.fx_px = camera.fy_px = std::numeric_limits<double>::quiet_NaN();
  }
  describe_lens(v, camera);
  if (reads) resolve_focal(v, camera, start, given, row.pixel_pitch_um);
  require_invertible(v, camera);
  v.section("eye_from_camera", mounted.mount, "pose of the camera in the eye");
}

}  // namespace saccade
