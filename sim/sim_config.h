#pragma once

#include <string>

#include "core/camera.h"
#include "emulator/emulator_config.h"
#include "sim/eye_renderer.h"
#include "sim/image_sampler.h"
#include "sim/lab.h"
#include "sim/world.h"

namespace saccade {

/// The configuration of the simulated robot and its world.
struct SimConfig {
  LabConfig lab;
  WorldConfig world;
  std::string eyes = "left";              ///< eyes with a camera: left or both
  Camera camera;                          ///< the left eye's
  CameraMount mount;                      ///< pose of the camera in the left eye
  MountedCamera right{right_dvs128, {}};  ///< the right eye's camera, with images of the same size
  EyeRenderConfig render;
  SamplingConfig sampling;
  std::string gl = "auto";  ///< OpenGL backend: auto, osmesa, egl
  EmulatorConfig emulator;
  bool labels = false;  ///< label each event with its cause and object; costs a second drawing per image

  [[nodiscard]] bool both_eyes() const { return eyes == "both"; }
};

}  // namespace saccade
