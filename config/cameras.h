#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/camera.h"

namespace saccade {

/// A camera that the key `preset` selects. docs/cameras.md has the sources of the values.
struct CameraPreset {
  std::string name;
  Camera camera;
  double pixel_pitch_um = 0.0;  ///< 0: not known
  std::string emulator;         ///< preset of the event camera's pixels that it brings along; empty: none
  bool has_regions = false;     ///< whether a smaller image is a region in the middle of its sensor
};

/// Presets: icub_left_2016, icub_right_2016 (the DVS128 cameras of iCubGenova02), pinhole, dvs128, davis240, davis346,
/// gen3_vga, gen4_hd.
[[nodiscard]] const std::vector<CameraPreset>& camera_preset_rows();
[[nodiscard]] const std::vector<std::string>& camera_presets();
/// Throws InputError for an unknown name.
[[nodiscard]] const CameraPreset& camera_preset_row(const std::string& name);
/// The camera of a preset. Throws InputError for an unknown name.
[[nodiscard]] Camera camera_preset(const std::string& name);
/// A camera without lens distortion: principal point in the middle of the image, square pixels, 0.777 times the image
/// width as focal length (65.5 deg from left to right, as icub_left_2016).
[[nodiscard]] Camera pinhole_camera(ImageSize size);

/// The angle from the left to the right border of the image through the principal point's row, deg.
[[nodiscard]] double field_of_view_deg(const Camera& camera);
/// The focal length, px, with which the lens shows `deg` in `width_px` pixels whose middle is the principal point; NaN
/// where the lens ends before that.
[[nodiscard]] double focal_px_of_view(const Camera& camera, double width_px, double deg);

/// The defaults of a camera's keys.
struct CameraDefault {
  std::string preset;
  ImageSize size;  ///< another size than the preset's: the pinhole of that size
  std::optional<Camera>
      camera;  ///< in place of both, unless the block has a preset or an image size of its own
};

/// Keys of a scenario's camera: preset, width_px, height_px, pixel_pitch_um, focal_mm, field_of_view_deg, then those of
/// the lens and of its mount. While a file is read, keys that it lacks have the values of the preset. An image size
/// without a preset gives the pinhole of that size. focal_mm and field_of_view_deg stand for fx_px and fy_px and are not
/// written; numbers that contradict each other are problems.
void describe_camera(FieldVisitor& v, MountedCamera& mounted, std::string& preset,
                     const CameraDefault& by_default);

}  // namespace saccade
