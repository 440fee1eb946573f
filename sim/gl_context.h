#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace saccade {

/// A device that EGL offers.
struct GlDevice {
  std::string name;       ///< its file, "/dev/dri/card0", or a word
  bool software = false;  ///< draws with the processor
};

/// A backend on this machine.
struct GlWay {
  std::string backend;      ///< "egl", "osmesa"
  std::string description;  ///< GlContext::description(), or why it does not work
  bool works = false;
};

/// An OpenGL context without a window, for rendering into offscreen buffers.
///
/// The libraries are loaded at run time: EGL, which needs no display (surfaceless), or OSMesa, which Mesa has up to 25.0.
/// Both draw in software with llvmpipe, with the same bytes where both are of one version of Mesa; EGL can draw with a GPU
/// too. MuJoCo takes its OpenGL functions from the one of the two that is loaded, so a program uses one backend for its
/// lifetime.
///
/// The number of threads of llvmpipe is the environment variable LP_NUM_THREADS (default: one per core); images do not
/// depend on it.
class GlContext {
 public:
  /// `backend`: one of backends(). "auto" is what the environment variable MUJOCO_GL says ("egl", "osmesa"); if it is not
  /// set, EGL, and OSMesa if that fails. A process that was forked after a context was created gets none.
  /// `device`: index in devices(), which implies EGL; software_device: llvmpipe, also on a machine with a GPU. The context
  /// is current afterwards. Throws InputError for another name, another value of MUJOCO_GL or an index that does not
  /// exist, RunError if there is no OpenGL.
  static std::unique_ptr<GlContext> create(std::string_view backend, std::int64_t device = software_device);
  static constexpr std::int64_t software_device = -1;
  /// The backends that "auto" tries, in its order, and whether they draw in software on this machine. It leaves the choice
  /// of a backend open.
  static std::vector<GlWay> ways();
  /// The devices that EGL offers, in its order; empty without EGL. Loads no OpenGL.
  static std::vector<GlDevice> devices();
  /// "auto", "egl", "osmesa".
  static const std::vector<std::string>& backends();

  virtual ~GlContext() = default;
  GlContext(const GlContext&) = delete;
  GlContext& operator=(const GlContext&) = delete;

  /// Makes the context current in the calling thread. Throws RunError when that fails.
  virtual void make_current() = 0;
  /// The address of an OpenGL function; nullptr if it does not exist.
  [[nodiscard]] virtual void* function(const char* name) const = 0;
  /// Backend, renderer and version, for reports: "egl, llvmpipe (...), 4.5 (...) Mesa 22.3.6".
  [[nodiscard]] const std::string& description() const { return description_; }

 protected:
  GlContext() = default;
  /// Fills description(); throws RunError when OpenGL is too old for MuJoCo.
  void identify(std::string_view backend);

 private:
  std::string description_;
};

}  // namespace saccade
