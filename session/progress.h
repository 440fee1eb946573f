#pragma once

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <string>

namespace saccade {

/// Progress on standard error: one changing line on a terminal, a line every tenth of the way in a log. What cannot be
/// written is dropped.
class Progress {
 public:
  /// `total`: how much there is to do, in any unit; 0 if unknown, then a line comes every 1000.
  explicit Progress(double total)
      : terminal_(isatty(STDERR_FILENO) != 0),
        step_((total > 0.0 ? total : 1e4) * (terminal_ ? 0.01 : 0.1)) {}
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  ~Progress() { done(); }

  /// Shows the text that `line` returns if `reached` of the total is a step further than at the last time.
  template <class Line>
  void show(double reached, const Line& line) {
    if (reached < next_) return;
    next_ = std::floor(reached / step_ + 1.0) * step_;
    write(fmt::format("{}{}{}", terminal_ ? "\r" : "", line(), terminal_ ? "" : "\n"));
    line_is_open_ = terminal_;
  }
  /// Prints a line of its own between those of the progress.
  void print_line(std::string_view line) {
    done();
    write(fmt::format("{}\n", line));
  }
  /// Ends the changing line.
  void done() {
    if (line_is_open_) write("\n");
    line_is_open_ = false;
  }

 private:
  static void write(const std::string& text) { std::fputs(text.c_str(), stderr); }

  bool terminal_;
  bool line_is_open_ = false;
  double step_;
  double next_ = 0.0;
};

}  // namespace saccade
