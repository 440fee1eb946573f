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

/// A window with Dear ImGui in it, and its OpenGL context, which other drawers may use. Its keyboard, mouse and
/// pictures belong to the thread that made it.
class Window final : public GlContext {
 public:
  /// Throws InputError where there is no display, RunError where it gives no window or no OpenGL.
  Window(const std::string& title, int width, int height);
  ~Window() override;

  void make_current() override;
  [[nodiscard]] void* function(const char* name) const override;
  /// Before MuJoCo draws here: shows it where OpenGL is, if nothing in the program did.
  void publish();

  [[nodiscard]] bool closed() const;
  void close();
  [[nodiscard]] int width() const;
  [[nodiscard]] int height() const;

  /// A key went down, or was held so long that it repeats.
  struct Key {
    int code = 0;  ///< as GLFW numbers keys
    bool shift = false;
    bool repeated = false;
  };

  /// Takes what keyboard and mouse did, having waited for it `timeout_s` at most; then panels may be drawn.
  void begin(double timeout_s);
  /// Pressed since the begin() before, however shortly; none that are typed into a field.
  [[nodiscard]] const std::vector<Key>& keys() const { return keys_; }
  /// Draws what was made since begin(), shows it, and gives what the window shows now where `grab` is not null: BGR.
  void end(cv::Mat* grab);

  /// A picture to be used by ImGui.
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
