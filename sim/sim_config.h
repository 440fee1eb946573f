#pragma once

#include <string>

#include "core/camera.h"
#include "emulator/emulator_config.h"
#include "sim/image_sampler.h"
#include "sim/lab.h"
#include "sim/renderer.h"
#include "sim/world.h"

namespace saccade {

/// Everything that makes the simulated world.
struct SimConfig {
  LabConfig lab;
  WorldConfig world;
  std::string eyes = "left";              ///< which of them see: left or both
  Camera camera;                          ///< the left eye's
  CameraMount mount;                      ///< of the camera in the left eye
  MountedCamera right{right_dvs128, {}};  ///< the right eye's camera; its image has the size of the left one
  EyeRenderConfig render;
  SamplingConfig sampling;
  std::string gl = "auto";  ///< OpenGL backend: auto, osmesa, egl
  EmulatorConfig emulator;
  bool labels = false;  ///< tell what made each event; costs a second drawing per image

  [[nodiscard]] bool both_eyes() const { return eyes == "both"; }
};

}  // namespace saccade
