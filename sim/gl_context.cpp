#include "sim/gl_context.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GL/gl.h>
#include <dlfcn.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdlib>
#include <filesystem>

#include "core/config.h"
#include "core/error.h"
#include "recording/module_path.h"
#include "sim/egl_devices.h"

namespace saccade {
namespace {

constexpr const char* osmesa_library = "libOSMesa.so.8";

/// A shared library whose symbols are private at first; publish() makes them global, where MuJoCo finds them. It stays loaded
/// until the program ends: what Mesa keeps for its next context would be lost memory otherwise.
class Library {
 public:
  explicit Library(const char* name)
      : name_(name), handle_(dlopen(name, RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE)) {
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

/// A context of a library that is loaded at run time.
class LibraryContext : public GlContext {
 public:
  /// Makes the library's functions those that MuJoCo finds. Throws RunError where it has found another library's.
  virtual void publish() const = 0;

 protected:
  explicit LibraryContext(const char* library) : library_(library) {}
  void publish_as(const char* backend, const char* symbol_of_other, const char* other) const {
    if (dlsym(RTLD_DEFAULT, symbol_of_other) != nullptr)
      throw RunError(std::string("no OpenGL through ") + backend + ": this program already uses " + other);
    library_.publish();
  }

  Library library_;
};

/// The Mesa that an archive of the program brings (scripts/archive): lib/saccade/libOSMesa.so.8 in a folder above the
/// program. Empty where there is none.
const std::string& own_mesa() {
  static const std::string file = [] {
    const std::filesystem::path program = module_path();
    for (std::filesystem::path folder = program.parent_path();
         !folder.empty() && folder != folder.root_path(); folder = folder.parent_path()) {
      std::error_code ignored;
      const std::filesystem::path mesa = folder / "lib/saccade" / osmesa_library;
      if (std::filesystem::exists(mesa, ignored)) return mesa.string();
    }
    return std::string();
  }();
  return file;
}

class OsmesaContext final : public LibraryContext {
 public:
  OsmesaContext()
      : LibraryContext(own_mesa().empty() ? osmesa_library : own_mesa().c_str()),
        make_current_(library_.get<MakeCurrent>("OSMesaMakeCurrent")),
        get_function_(library_.get<GetFunction>("OSMesaGetProcAddress")),
        destroy_(library_.get<Destroy>("OSMesaDestroyContext")) {
    context_ = library_.get<Create>("OSMesaCreateContextExt")(GL_RGBA, 24, 8, 0, nullptr);
    if (context_ == nullptr) throw RunError("no OpenGL: OSMesa creates no context");
    OsmesaContext::make_current();
    identify("osmesa");
  }
  ~OsmesaContext() override {
    make_current_(nullptr, nullptr, 0, 0, 0);
    destroy_(context_);
  }

  void publish() const override { publish_as("osmesa", "eglGetProcAddress", "egl"); }
  void make_current() override {
    if (make_current_(context_, window_.data(), GL_UNSIGNED_BYTE, window_side, window_side) != GL_TRUE) {
      throw RunError("OpenGL failed: OSMesaMakeCurrent");
    }
  }
  [[nodiscard]] void* function(const char* name) const override {
    return reinterpret_cast<void*>(get_function_(name));
  }

 private:
  // The functions of GL/osmesa.h, which Mesa from 25.1 on does not have.
  using Create = void*(GLenum format, GLint depth_bits, GLint stencil_bits, GLint accumulator_bits,
                       void* shared);
  using MakeCurrent = GLboolean(void* context, void* image, GLenum type, GLsizei width, GLsizei height);
  using GetFunction = void (*(const char* name))();
  using Destroy = void(void* context);
  static constexpr int window_side = 8;

  MakeCurrent* make_current_;
  GetFunction* get_function_;
  Destroy* destroy_;
  void* context_ = nullptr;
  std::array<std::byte, 4 * window_side * window_side> window_{};  ///< unused, but required by OSMesa
};

class EglContext final : public LibraryContext {
 public:
  explicit EglContext(std::int64_t device)
      : LibraryContext("libEGL.so.1"),
        make_current_(library_.get<decltype(eglMakeCurrent)>("eglMakeCurrent")),
        get_function_(library_.get<decltype(eglGetProcAddress)>("eglGetProcAddress")),
        destroy_(library_.get<decltype(eglDestroyContext)>("eglDestroyContext")) {
    library_.get<decltype(eglBindAPI)>("eglBindAPI")(EGL_OPENGL_API);
    if (device == software_device) {
      open_software();
    } else {
      open(device);
    }
  }
  ~EglContext() override { close(); }

  void publish() const override { publish_as("egl", "OSMesaGetProcAddress", "osmesa"); }
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
  /// The device that is software; where EGL lists none, Mesa's display without a surface if that draws in software.
  void open_software() {
    for (const detail::EglDevice& device : detail::egl_devices(get_function_)) {
      if (device.description.software && open(detail::display_of(device, get_function_))) return;
    }
    const auto get_display =
        reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(get_function_("eglGetPlatformDisplayEXT"));
    if (get_display == nullptr ||
        !open(get_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr)))
      throw RunError("no OpenGL: EGL creates no context that draws in software");
    if (description().find("llvmpipe") != std::string::npos ||
        description().find("softpipe") != std::string::npos)
      return;
    const std::string found = description();
    close();
    throw RunError("no OpenGL in software: " + found + "; render.device chooses a GPU");
  }
  /// Creates the context on a display and makes it current. Returns false where that fails.
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
    EglContext::make_current();
    identify("egl");
    return true;
  }
  void close() {
    // The display stays initialised: it belongs to the whole program.
    make_current_(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    destroy_(display_, context_);
  }

  decltype(eglMakeCurrent)* make_current_;
  decltype(eglGetProcAddress)* get_function_;
  decltype(eglDestroyContext)* destroy_;
  EGLDisplay display_ = EGL_NO_DISPLAY;
  EGLContext context_ = EGL_NO_CONTEXT;
};

const char* variable(const char* name) {
  const char* const value = std::getenv(name);
  return value == nullptr || *value == '\0' ? nullptr : value;
}

/// The folder in which Mesa keeps compiled shaders, which saves half a second of each run; empty where there is none to be.
std::filesystem::path shader_folder() {
  std::filesystem::path folder;
  if (const char* const cache = variable("XDG_CACHE_HOME"); cache != nullptr) {
    folder = cache;
  } else if (const char* const home = variable("HOME"); home != nullptr) {
    folder = std::filesystem::path(home) / ".cache";
  }
  std::error_code ignored;
  std::filesystem::create_directory(folder, ignored);  // as Mesa would
  const bool usable = ::access(folder.c_str(), W_OK | X_OK) == 0;
  return usable ? folder : std::filesystem::path();
}

/// Mesa prints to the terminal which drivers it has tried in vain and which folder it cannot make, unless these variables
/// are set. Those that the user has set stay.
void keep_mesa_quiet() {
  setenv("EGL_LOG_LEVEL", "fatal", 0);
  setenv("MESA_LOG", "null", 0);
  if (variable("MESA_SHADER_CACHE_DIR") != nullptr || variable("MESA_SHADER_CACHE_DISABLE") != nullptr)
    return;
  if (const std::filesystem::path folder = shader_folder(); folder.empty()) {
    setenv("MESA_SHADER_CACHE_DISABLE", "true", 0);
  } else {
    setenv("MESA_SHADER_CACHE_DIR", folder.c_str(), 0);
  }
}

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

std::unique_ptr<LibraryContext> open_backend(std::string_view backend, std::int64_t device) {
  keep_mesa_quiet();
  if (backend == "egl") return std::make_unique<EglContext>(device);
  return std::make_unique<OsmesaContext>();
}

std::unique_ptr<GlContext> use_backend(std::string_view backend, std::int64_t device) {
  std::unique_ptr<LibraryContext> context = open_backend(backend, device);
  context->publish();
  return context;
}

/// In the order in which "auto" tries them.
std::array<std::string_view, 2> ways_to_draw() {
  if (own_mesa().empty()) return {"egl", "osmesa"};
  return {"osmesa", "egl"};
}

/// What the environment variable MUJOCO_GL says, "auto" where it is not set or empty.
std::string backend_of_environment() {
  const char* const set = variable("MUJOCO_GL");
  if (set == nullptr) return "auto";
  std::string wanted = set;
  if (wanted != "egl" && wanted != "osmesa")
    throw InputError("MUJOCO_GL", wanted, "egl, osmesa, or that the variable is not set");
  return wanted;
}

}  // namespace

const std::vector<std::string>& GlContext::backends() {
  static const std::vector<std::string> names{"auto", "egl", "osmesa"};
  return names;
}

std::vector<GlWay> GlContext::ways() {
  require_threads_of_opengl();
  std::vector<GlWay> ways;
  for (const std::string_view backend : ways_to_draw()) {
    try {
      ways.push_back({std::string(backend), open_backend(backend, software_device)->description(), true});
    } catch (const RunError& error) {
      ways.push_back({std::string(backend), error.what(), false});
    }
  }
  return ways;
}

std::vector<GlDevice> GlContext::devices() {
  keep_mesa_quiet();
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
  if (device != software_device) {
    if (backend == "osmesa")
      throw InputError("render.device", std::to_string(device), "backend: egl; osmesa has no devices");
    return use_backend("egl", device);
  }
  const std::string wanted = backend == "auto" ? backend_of_environment() : std::string(backend);
  if (wanted != "auto") return use_backend(wanted, software_device);
  std::string problems;
  for (const std::string_view way : ways_to_draw()) {
    try {
      return use_backend(way, software_device);
    } catch (const RunError& error) {
      problems += (problems.empty() ? "" : "; ") + std::string(error.what());
    }
  }
  throw RunError(problems);
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

}  // namespace saccade

#if defined(__SANITIZE_ADDRESS__)
// Mesa keeps some 100 bytes for each context that it destroys, and more for windows; read by the leak sanitizer.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libOSMesa.so\nleak:libEGL\nleak:libGLX\nleak:swrast_dri.so\nleak:libgallium\n";
}
#endif
