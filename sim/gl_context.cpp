#include "sim/gl_context.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GL/osmesa.h>
#include <dlfcn.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdlib>

#include "core/config.h"
#include "core/error.h"
#include "sim/egl_devices.h"

namespace saccade::inline v0_1 {
namespace {

/// A shared library whose symbols are private at first; publish() makes them global, where MuJoCo finds them.
class Library {
 public:
  explicit Library(const char* name) : name_(name), handle_(dlopen(name, RTLD_NOW | RTLD_LOCAL)) {
    if (handle_ == nullptr) throw RunError(std::string("no OpenGL: ") + dlerror());
  }
  ~Library() { dlclose(handle_); }
  Library(const Library&) = delete;
  Library& operator=(const Library&) = delete;

  template <class Function>
  Function* get(const char* symbol) const {
    void* address = dlsym(handle_, symbol);
    if (address == nullptr) throw RunError(std::string("no OpenGL: ") + name_ + " has no " + symbol);
    return reinterpret_cast<Function*>(address);
  }
  void publish() const {
    // The second handle is kept on purpose: MuJoCo goes on using the library's functions.
    dlopen(name_, RTLD_NOW | RTLD_GLOBAL | RTLD_NOLOAD);
  }

 private:
  const char* name_;
  void* handle_;
};

void require_no_other_backend(const char* symbol, const char* wanted, const char* other) {
  if (dlsym(RTLD_DEFAULT, symbol) != nullptr) {
    throw RunError(std::string("no OpenGL through ") + wanted + ": this program already uses " + other);
  }
}

class OsmesaContext final : public GlContext {
 public:
  OsmesaContext()
      : library_("libOSMesa.so.8"),
        make_current_(library_.get<decltype(OSMesaMakeCurrent)>("OSMesaMakeCurrent")),
        get_function_(library_.get<decltype(OSMesaGetProcAddress)>("OSMesaGetProcAddress")),
        destroy_(library_.get<decltype(OSMesaDestroyContext)>("OSMesaDestroyContext")) {
    require_no_other_backend("eglGetProcAddress", "osmesa", "egl");
    const auto create = library_.get<decltype(OSMesaCreateContextExt)>("OSMesaCreateContextExt");
    context_ = create(OSMESA_RGBA, 24, 8, 0, nullptr);
    if (context_ == nullptr) throw RunError("no OpenGL: OSMesa creates no context");
    OsmesaContext::make_current();
    identify("osmesa");
    library_.publish();
  }
  ~OsmesaContext() override {
    make_current_(nullptr, nullptr, 0, 0, 0);
    destroy_(context_);
  }

  void make_current() override {
    if (make_current_(context_, window_.data(), GL_UNSIGNED_BYTE, window_side, window_side) != GL_TRUE) {
      throw RunError("OpenGL failed: OSMesaMakeCurrent");
    }
  }
  [[nodiscard]] void* function(const char* name) const override {
    return reinterpret_cast<void*>(get_function_(name));
  }

 private:
  static constexpr int window_side = 8;

  Library library_;
  decltype(OSMesaMakeCurrent)* make_current_;
  decltype(OSMesaGetProcAddress)* get_function_;
  decltype(OSMesaDestroyContext)* destroy_;
  OSMesaContext context_ = nullptr;
  std::array<std::byte, 4 * window_side * window_side> window_{};  ///< unused, but required by OSMesa
};

class EglContext final : public GlContext {
 public:
  explicit EglContext(std::int64_t device)
      : library_("libEGL.so.1"),
        make_current_(library_.get<decltype(eglMakeCurrent)>("eglMakeCurrent")),
        get_function_(library_.get<decltype(eglGetProcAddress)>("eglGetProcAddress")),
        destroy_(library_.get<decltype(eglDestroyContext)>("eglDestroyContext")) {
    require_no_other_backend("OSMesaGetProcAddress", "egl", "osmesa");
    library_.get<decltype(eglBindAPI)>("eglBindAPI")(EGL_OPENGL_API);
    if (device == any_device) {
      open_any();
    } else {
      open(device);
    }
    EglContext::make_current();
    identify("egl");
    library_.publish();
  }
  ~EglContext() override {
    // The display stays initialised: it belongs to the whole program.
    make_current_(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    destroy_(display_, context_);
  }

  void make_current() override {
    if (make_current_(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) != EGL_TRUE) {
      throw RunError("OpenGL failed: eglMakeCurrent");
    }
  }
  [[nodiscard]] void* function(const char* name) const override {
    return reinterpret_cast<void*>(get_function_(name));
  }

 private:
  /// The device with that index.
  void open(std::int64_t index) {
    const std::vector<detail::EglDevice> devices = detail::egl_devices(get_function_);
    if (index >= static_cast<std::int64_t>(devices.size())) {
      throw InputError("render.device", std::to_string(index),
                       "the index of one of the " + std::to_string(devices.size()) +
                           " devices that `saccade --version` lists");
    }
    if (!open(detail::display_of(devices[static_cast<std::size_t>(index)], get_function_)))
      throw RunError("no OpenGL: EGL creates no context on device " + std::to_string(index));
  }
  /// The first device that is not software, otherwise Mesa's display without a surface, otherwise the default display.
  void open_any() {
    for (const detail::EglDevice& device : detail::egl_devices(get_function_)) {
      if (!device.description.software && open(detail::display_of(device, get_function_))) return;
    }
    const auto get_display =
        reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(get_function_("eglGetPlatformDisplayEXT"));
    if (get_display != nullptr &&
        open(get_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr))) {
      return;
    }
    if (!open(library_.get<decltype(eglGetDisplay)>("eglGetDisplay")(EGL_DEFAULT_DISPLAY)))
      throw RunError("no OpenGL: EGL creates no context");
  }
  /// Creates the context on a display. Returns false where that fails.
  bool open(EGLDisplay display) {
    const auto initialize = library_.get<decltype(eglInitialize)>("eglInitialize");
    if (display == EGL_NO_DISPLAY || initialize(display, nullptr, nullptr) != EGL_TRUE) return false;
    const std::array<EGLint, 5> wanted{EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_SURFACE_TYPE, EGL_PBUFFER_BIT,
                                       EGL_NONE};
    EGLConfig config = nullptr;
    EGLint found = 0;
    const auto choose = library_.get<decltype(eglChooseConfig)>("eglChooseConfig");
    if (choose(display, wanted.data(), &config, 1, &found) != EGL_TRUE || found != 1) return false;
    context_ = library_.get<decltype(eglCreateContext)>("eglCreateContext")(display, config, EGL_NO_CONTEXT,
                                                                            nullptr);
    if (context_ == EGL_NO_CONTEXT) return false;
    display_ = display;
    return true;
  }

  Library library_;
  decltype(eglMakeCurrent)* make_current_;
  decltype(eglGetProcAddress)* get_function_;
  decltype(eglDestroyContext)* destroy_;
  EGLDisplay display_ = EGL_NO_DISPLAY;
  EGLContext context_ = EGL_NO_CONTEXT;
};

/// The libraries of OpenGL draw with threads of their own, which a forked process does not have: it would wait for them for
/// ever.
void require_threads_of_opengl() {
  static const pid_t first = ::getpid();  // of the process that used OpenGL first
  if (::getpid() == first) return;
  throw RunError(
      "no OpenGL: this process is a fork of one that has used it, without the threads of OpenGL; start "
      "processes "
      "another way (Python: multiprocessing.get_context(\"spawn\"))");
}

bool has_display() {
  const char* x11 = std::getenv("DISPLAY");
  const char* wayland = std::getenv("WAYLAND_DISPLAY");
  return (x11 != nullptr && *x11 != '\0') || (wayland != nullptr && *wayland != '\0');
}

std::unique_ptr<GlContext> create_one(std::string_view backend) {
  if (backend == "egl") return std::make_unique<EglContext>(GlContext::any_device);
  return std::make_unique<OsmesaContext>();
}

}  // namespace

const std::vector<std::string>& GlContext::backends() {
  static const std::vector<std::string> names{"auto", "osmesa", "egl"};
  return names;
}

std::vector<GlDevice> GlContext::devices() {
  try {
    const Library library("libEGL.so.1");
    std::vector<GlDevice> descriptions;
    for (const detail::EglDevice& device :
         detail::egl_devices(library.get<decltype(eglGetProcAddress)>("eglGetProcAddress")))
      descriptions.push_back(device.description);
    return descriptions;
  } catch (const RunError&) {
    return {};
  }
}

std::unique_ptr<GlContext> GlContext::create(std::string_view backend, std::int64_t device) {
  require_threads_of_opengl();
  if (std::find(backends().begin(), backends().end(), backend) == backends().end()) {
    throw InputError("backend", std::string(backend), expectation_of(backends()));
  }
  if (device != any_device) {
    if (backend == "osmesa")
      throw InputError("render.device", std::to_string(device), "backend: egl; osmesa has no devices");
    return std::make_unique<EglContext>(device);
  }
  if (backend != "auto") return create_one(backend);
  const std::array<const char*, 2> order =
      has_display() ? std::array{"egl", "osmesa"} : std::array{"osmesa", "egl"};
  try {
    return create_one(order[0]);
  } catch (const RunError& first) {
    try {
      return create_one(order[1]);
    } catch (const RunError& second) {
      throw RunError(std::string(first.what()) + "; " + second.what());
    }
  }
}

void GlContext::identify(std::string_view backend) {
  using GetString = const GLubyte*(GLenum);
  const auto get_string = reinterpret_cast<GetString*>(function("glGetString"));
  const auto text = [&](GLenum name) {
    const GLubyte* found = get_string == nullptr ? nullptr : get_string(name);
    return found == nullptr ? std::string() : std::string(reinterpret_cast<const char*>(found));
  };
  // MuJoCo ends the program without this extension.
  if (text(GL_EXTENSIONS).find("GL_ARB_framebuffer_object") == std::string::npos) {
    throw RunError("no OpenGL: " + std::string(backend) + " offers no offscreen framebuffers");
  }
  description_ = std::string(backend) + ", " + text(GL_RENDERER) + ", " + text(GL_VERSION);
}

}  // namespace saccade::inline v0_1

#if defined(__SANITIZE_ADDRESS__)
// Mesa keeps some 100 bytes for each OSMesa context that it destroys, and more for windows; read by the leak sanitizer.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libOSMesa.so\nleak:libGLX\nleak:swrast_dri.so\n";
}
#endif
