#include "sim/egl_devices.h"

#include <string>
#include <string_view>

namespace saccade::detail {
namespace {

template <class Function>
Function function_of(decltype(eglGetProcAddress)* get_function, const char* name) {
  return reinterpret_cast<Function>(get_function(name));
}

}  // namespace

std::vector<EglDevice> egl_devices(decltype(eglGetProcAddress)* get_function) {
  const auto query = function_of<PFNEGLQUERYDEVICESEXTPROC>(get_function, "eglQueryDevicesEXT");
  const auto text_of = function_of<PFNEGLQUERYDEVICESTRINGEXTPROC>(get_function, "eglQueryDeviceStringEXT");
  EGLint count = 0;
  if (query == nullptr || text_of == nullptr || query(0, nullptr, &count) != EGL_TRUE || count <= 0)
    return {};
  std::vector<EGLDeviceEXT> handles(static_cast<std::size_t>(count));
  if (query(count, handles.data(), &count) != EGL_TRUE) return {};
  handles.resize(static_cast<std::size_t>(count));
  std::vector<EglDevice> devices;
  for (const EGLDeviceEXT handle : handles) {
    const char* const extensions = text_of(handle, EGL_EXTENSIONS);
    const std::string_view offered = extensions == nullptr ? "" : extensions;
    const auto has = [&](std::string_view name) { return offered.find(name) != std::string_view::npos; };
    EglDevice device{handle, {"device", has("EGL_MESA_device_software")}};
    if (device.description.software) {
      device.description.name = "software";
    } else if (const char* file =
                   has("EGL_EXT_device_drm") ? text_of(handle, EGL_DRM_DEVICE_FILE_EXT) : nullptr) {
      device.description.name = file;
    } else if (has("EGL_NV_device_cuda")) {
      device.description.name = "NVIDIA";
    }
    devices.push_back(std::move(device));
  }
  return devices;
}

EGLDisplay display_of(const EglDevice& device, decltype(eglGetProcAddress)* get_function) {
  const auto get_display =
      function_of<PFNEGLGETPLATFORMDISPLAYEXTPROC>(get_function, "eglGetPlatformDisplayEXT");
  if (get_display == nullptr) return EGL_NO_DISPLAY;
  return get_display(EGL_PLATFORM_DEVICE_EXT, device.handle, nullptr);
}

}  // namespace saccade::detail
