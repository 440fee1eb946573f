#pragma once

#include <array>
#include <string>

#include "core/camera.h"
#include "emulator/emulator_config.h"
#include "head/icub_cameras.h"
#include "sim/eye_renderer.h"
#include "sim/image_sampler.h"
#include "sim/lab.h"
#include "sim/world.h"

namespace saccade {

/// Eyes that have a camera.
enum class Eyes { left, both };
constexpr auto words_of(Eyes) {
  return std::to_array<Word<Eyes>>({{Eyes::left, "left"}, {Eyes::both, "both"}});
}

/// The configuration of the simulated robot and its world.
struct SimConfig {
  LabConfig lab;
  WorldConfig world;
  Eyes eyes = Eyes::left;
  Camera camera = icub_left_2016;            ///< the left eye's
  CameraMount mount;                         ///< pose of the camera in the left eye
  MountedCamera right{icub_right_2016, {}};  ///< the right eye's camera, with images of the same size
  EyeRenderConfig render;
  SamplingConfig sampling;
  std::string gl = "auto";      ///< OpenGL backend, of GlContext::backends()
  std::int64_t gl_device = -1;  ///< of GlContext::devices(); -1: software
  EmulatorConfig emulator;
  bool labels = false;  ///< label each event with its cause and object; costs a second drawing per image

  [[nodiscard]] bool both_eyes() const { return eyes == Eyes::both; }
};

}  // namespace saccade
