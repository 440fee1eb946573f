#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/camera.h"

namespace saccade {

/// Names that the key `preset` of a scenario's camera takes: icub_left_2016, icub_right_2016 (the DVS128 cameras of
/// iCubGenova02), pinhole.
[[nodiscard]] const std::vector<std::string>& camera_presets();
/// The camera of a preset. Throws InputError for an unknown name.
[[nodiscard]] Camera camera_preset(const std::string& name);
/// A camera without lens distortion: principal point in the middle of the image, square pixels, 0.777 times the image
/// width as focal length (65.5 deg from left to right, as icub_left_2016).
[[nodiscard]] Camera pinhole_camera(ImageSize size);

/// The defaults of a camera's keys.
struct CameraDefault {
  std::string preset;
  ImageSize size;  ///< another size than the preset's: the pinhole of that size
  std::optional<Camera>
      camera;  ///< in place of both, unless the block has a preset or an image size of its own
};

/// Keys of a scenario's camera: preset, then those of MountedCamera. While a file is read, keys that it lacks have the
/// values of the preset. An image size without a preset gives the pinhole of that size.
void describe_camera(FieldVisitor& v, MountedCamera& mounted, std::string& preset,
                     const CameraDefault& by_default);

}  // namespace saccade
