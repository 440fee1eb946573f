#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace saccade::inline v0_1 {

/// A device that EGL offers.
struct GlDevice {
  std::string name;       ///< its file, "/dev/dri/card0", or a word
  bool software = false;  ///< draws with the processor
};

/// An OpenGL context without a window, for rendering into offscreen buffers.
///
/// The libraries are loaded at run time, so that one program renders with OSMesa (software, without display and device)
/// or EGL (surfaceless, with a GPU if there is one). MuJoCo takes its OpenGL functions from the one of the two that is
/// loaded, so a program uses one backend for its lifetime.
///
/// In software both render with llvmpipe, whose number of threads is the environment variable LP_NUM_THREADS (default:
/// one per core); images do not depend on it.
class GlContext {
 public:
  /// `backend`: one of backends(). "auto" is OSMesa without a display and EGL with one; if that one fails, the other is
  /// used. EGL draws with the first device that is not software, without one with Mesa's software. A process that was forked
  /// after a context was created gets none.
  /// `device`: index in devices() instead, which implies EGL; any_device: none. The context is current afterwards. Throws
  /// InputError for another name or an index that does not exist, RunError if there is no OpenGL.
  static std::unique_ptr<GlContext> create(std::string_view backend, std::int64_t device = any_device);
  static constexpr std::int64_t any_device = -1;
  /// The devices that EGL offers, in its order; empty without EGL. Loads no OpenGL.
  static std::vector<GlDevice> devices();
  /// "auto", "osmesa", "egl".
  static const std::vector<std::string>& backends();

  virtual ~GlContext() = default;
  GlContext(const GlContext&) = delete;
  GlContext& operator=(const GlContext&) = delete;

  /// Makes the context current in the calling thread. Throws RunError when that fails.
  virtual void make_current() = 0;
  /// The address of an OpenGL function; nullptr if it does not exist.
  [[nodiscard]] virtual void* function(const char* name) const = 0;
  /// Backend, renderer and version, for reports: "osmesa, llvmpipe (...), 4.5 (...) Mesa 22.3.6".
  [[nodiscard]] const std::string& description() const { return description_; }

 protected:
  GlContext() = default;
  /// Fills description(); throws RunError when OpenGL is too old for MuJoCo.
  void identify(std::string_view backend);

 private:
  std::string description_;
};

}  // namespace saccade::inline v0_1
