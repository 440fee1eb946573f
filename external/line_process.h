#pragma once

#include <sys/types.h>
#include <chrono>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "external/socket_address.h"

namespace saccade {

/// A program to start.
struct ProgramCall {
  std::vector<std::string>
      words;                ///< the program, found in PATH where its name has no slash, and its arguments
  std::string folder = {};  ///< its working directory; empty: that of this process
};

/// A program that answers each message with one line: one that this object starts, or one that listens.
///
/// A started program's standard input and output are one socket of this process; its standard error is that of this process.
/// It runs in a process group of its own, which ends with this object. A program that listens runs on; the connection
/// ends with this object.
class LineProcess {
 public:
  enum class Status {
    ok,
    late,     ///< no whole line within the time limit
    ended,    ///< the program has ended, or closed its standard output or the connection
    unasked,  ///< the program has answered more than it was asked
    endless,  ///< a line of more than `longest_line` bytes
  };
  static constexpr std::size_t longest_line = 4096;

  /// The program to start, or where one listens.
  using Place = std::variant<ProgramCall, SocketAddress>;

  /// Throws RunError where the program cannot be started, and where none listens within `limit`.
  LineProcess(const Place& place, std::chrono::milliseconds limit);
  ~LineProcess();
  LineProcess(const LineProcess&) = delete;
  LineProcess& operator=(const LineProcess&) = delete;

  /// Sends the message and waits for a line of answer, without its end. `limit`: of the wall clock, for both. After
  /// another status than ok there is no further exchange.
  [[nodiscard]] Status exchange(std::string_view message, std::chrono::milliseconds limit,
                                std::string& answer);

  /// Ends the program or the connection: a program that does not end within `patience` by itself is killed, and its end is not
  /// waited for, since the system takes a second to free some gigabytes. Returns how it ended: "with status 1", "by signal
  /// 11 (Segmentation fault)", "its connection to localhost:5000 is closed"; nothing where it was killed.
  std::string end(std::chrono::milliseconds patience);

 private:
  void start(const ProgramCall& call);
  [[nodiscard]] Status take_line(std::string& answer);
  void close_socket();

  pid_t child_ = -1;
  std::string peer_;  ///< of a connection
  int socket_ = -1;
  std::string received_;
};

}  // namespace saccade
