#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <span>
#include <string>
#include <vector>

#include "core/event.h"
#include "sim/gl_context.h"

struct GLFWwindow;

namespace saccade {

/// A window with Dear ImGui in it, and its OpenGL context, which other renderers may use. Used from the thread that made
/// it alone.
class Window final : public GlContext {
 public:
  /// Throws InputError where there is no display, RunError where it gives no window or no OpenGL.
  Window(const std::string& title, int width, int height);
  ~Window() override;

  void make_current() override;
  [[nodiscard]] void* function(const char* name) const override;
  /// Loads libGL so that MuJoCo finds its functions, unless another OpenGL library is loaded. Call it before MuJoCo
  /// draws here. Throws RunError where there is none.
  void publish();

  [[nodiscard]] bool closed() const;
  void close();
  /// Takes back a request to close the window.
  void keep_open();
  /// Takes the window off the screen; it stays usable.
  void hide();
  [[nodiscard]] int width() const;
  [[nodiscard]] int height() const;

  /// A key that was pressed, or that repeats because it is held.
  struct Key {
    int code = 0;  ///< as GLFW numbers keys
    bool shift = false;
    bool repeated = false;
  };

  /// Reads keyboard and mouse, after waiting up to `timeout_s` for them, and begins a drawing.
  void begin(double timeout_s);
  /// The keys pressed between the last two begin(), without those typed into a field.
  [[nodiscard]] const std::vector<Key>& keys() const { return keys_; }
  /// Ends the drawing and shows it. `grab`: receives what the window shows, BGR; may be null.
  void end(cv::Mat* grab);

  /// An image for ImGui.
  class Texture {
   public:
    Texture(Window& window, bool smooth);
    ~Texture();
    Texture(const Texture&) = delete;
    Texture& operator=(const Texture&) = delete;
    /// RGB, row by row, top row first.
    void set(ImageSize size, std::span<const std::uint8_t> rgb);
    [[nodiscard]] void* id() const;  ///< an ImTextureID

   private:
    Window& window_;
    unsigned int name_ = 0;
    ImageSize size_;
  };

 private:
  struct Functions;
  GLFWwindow* window_ = nullptr;
  std::vector<Key> keys_;
  std::unique_ptr<Functions> gl_;
};

}  // namespace saccade
