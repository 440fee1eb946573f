#pragma once

#include <sys/types.h>
#include <chrono>
#include <string>
#include <string_view>
#include <vector>

namespace saccade {

/// A program that answers each message with one line. Its standard input and output are one socket of this process; its
/// standard error is that of this process. It runs in a process group of its own, which ends with this object.
class LineProcess {
 public:
  enum class Status {
    ok,
    late,     ///< no whole line within the time limit
    ended,    ///< the program has ended, or closed its standard output
    unasked,  ///< the program has answered more than it was asked
    endless,  ///< a line of more than `longest_line` bytes
  };
  static constexpr std::size_t longest_line = 4096;

  /// `words`: the program, found in PATH where its name has no slash, and its arguments. Throws RunError where it cannot
  /// be started.
  explicit LineProcess(std::vector<std::string> words);
  ~LineProcess();
  LineProcess(const LineProcess&) = delete;
  LineProcess& operator=(const LineProcess&) = delete;

  /// Sends the message and waits for a line of answer, without its end. `limit`: of the wall clock, for both. After
  /// another status than ok there is no further exchange.
  [[nodiscard]] Status exchange(std::string_view message, std::chrono::milliseconds limit,
                                std::string& answer);

  /// Ends the program if it runs, and returns how it ended: "with status 1", "by signal 11 (Segmentation fault)".
  std::string stop();

 private:
  [[nodiscard]] Status take_line(std::string& answer);
  void close_socket();

  pid_t child_ = -1;
  int socket_ = -1;
  std::string received_;
};

}  // namespace saccade
