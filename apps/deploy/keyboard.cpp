#include "apps/deploy/keyboard.h"

#include <poll.h>
#include <termios.h>
#include <unistd.h>

namespace saccade {
namespace {

constexpr int poll_ms = 50;

}  // namespace

bool Keyboard::is_there() {
  // A program in the background must not touch the terminal.
  return isatty(STDIN_FILENO) != 0 && tcgetpgrp(STDIN_FILENO) == getpgrp();
}

Keyboard::Keyboard(std::function<void(char)> pressed) : pressed_(std::move(pressed)) {
  if (!is_there()) return;
  thread_ = std::thread([this] {
    termios before{};
    tcgetattr(STDIN_FILENO, &before);
    termios raw = before;
    raw.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);  // each key at once; Ctrl-C still is a signal
    tcsetattr(STDIN_FILENO, TCSANOW, &raw);
    while (!over_) {
      pollfd in{STDIN_FILENO, POLLIN, 0};
      if (poll(&in, 1, poll_ms) <= 0) continue;
      char key = 0;
      if (read(STDIN_FILENO, &key, 1) != 1) break;
      pressed_(key);
    }
    tcsetattr(STDIN_FILENO, TCSANOW, &before);
  });
}

Keyboard::~Keyboard() {
  over_ = true;
  if (thread_.joinable()) thread_.join();
}

}  // namespace saccade
