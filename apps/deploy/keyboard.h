#pragma once

#include <atomic>
#include <functional>
#include <thread>

namespace saccade {

/// Single keys of a person at the terminal, as they are pressed; nothing where standard input is none. The terminal is
/// as it was when this is gone.
class Keyboard {
 public:
  /// `pressed` is called in a thread of its own.
  explicit Keyboard(std::function<void(char)> pressed);
  Keyboard(const Keyboard&) = delete;
  Keyboard& operator=(const Keyboard&) = delete;
  ~Keyboard();

  /// Whether there is a terminal to press keys at.
  [[nodiscard]] static bool is_there();

 private:
  std::function<void(char)> pressed_;
  std::atomic<bool> over_ = false;
  std::thread thread_;
};

}  // namespace saccade
