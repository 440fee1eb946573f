#pragma once

#include <EGL/egl.h>
#include <EGL/eglext.h>

#include <vector>

#include "sim/gl_context.h"

namespace saccade::detail {

/// A device of EGL's enumeration (EGL_EXT_device_enumeration).
struct EglDevice {
  EGLDeviceEXT handle = EGL_NO_DEVICE_EXT;
  GlDevice description;
};

/// The devices that a loaded EGL offers, in its order; empty where it enumerates none. `get_function`: its
/// eglGetProcAddress.
[[nodiscard]] std::vector<EglDevice> egl_devices(decltype(eglGetProcAddress)* get_function);

/// The display of a device; EGL_NO_DISPLAY where EGL has none for devices.
[[nodiscard]] EGLDisplay display_of(const EglDevice& device, decltype(eglGetProcAddress)* get_function);

}  // namespace saccade::detail
