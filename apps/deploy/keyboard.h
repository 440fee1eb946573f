#pragma once

#include <atomic>
#include <functional>
#include <thread>

namespace saccade {

/// Reads single keys from the terminal on standard input, if it is one. Restores the terminal's mode at its end.
class Keyboard {
 public:
  /// `pressed` is called for each key, in a thread of its own.
  explicit Keyboard(std::function<void(char)> pressed);
  Keyboard(const Keyboard&) = delete;
  Keyboard& operator=(const Keyboard&) = delete;
  ~Keyboard();

  /// Whether standard input is a terminal and the program is in its foreground.
  [[nodiscard]] static bool is_there();

 private:
  std::function<void(char)> pressed_;
  std::atomic<bool> over_ = false;
  std::thread thread_;
};

}  // namespace saccade
