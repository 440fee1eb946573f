#include "apps/config/cameras.h"

#include "core/units.h"

namespace saccade {
namespace {

constexpr const char* pinhole = "pinhole";

}  // namespace

const std::vector<std::string>& camera_presets() {
  static const std::vector<std::string> names = {"icub_left_2016", "icub_right_2016", pinhole};
  return names;
}

Camera pinhole_camera(ImageSize size) {
  constexpr double focal_per_width = 0.777;
  Camera camera = Camera{}.without_lens();
  camera.size = size;
  camera.fx_px = camera.fy_px = focal_per_width * size.width;
  camera.cx_px = 0.5 * (size.width - 1);
  camera.cy_px = 0.5 * (size.height - 1);
  return camera;
}

Camera camera_preset(const std::string& name) {
  if (name == "icub_left_2016") return Camera{};
  if (name == "icub_right_2016") return right_dvs128;
  if (name == pinhole) return pinhole_camera(Camera{}.size);
  throw InputError("camera.preset", name, expectation_of(camera_presets()));
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
  const ImageSize image = camera_preset(preset).size;
  v.require(preset == pinhole || camera.size == image, "width_px", in_words(camera.size),
            in_words(image) + ", the image of the preset " + preset + "; without a preset any size");
  describe_lens(v, camera);
  v.section("eye_from_camera", mounted.mount, "pose of the camera in the eye");
}

}  // namespace saccade
