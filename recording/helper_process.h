#pragma once

#include <sys/types.h>

#include <optional>
#include <string>

#include "recording/helper_protocol.h"

namespace saccade {

struct HelperCommand;

/// A helper process that reads a file (recording/helper_reader.h), and the messages that it sends.
class HelperProcess {
 public:
  /// `name`: of the file, `library`: that reads it, for messages. Throws RunError where the helper cannot be started.
  HelperProcess(std::string name, std::string library, const HelperCommand& command);
  HelperProcess(const HelperProcess&) = delete;
  HelperProcess& operator=(const HelperProcess&) = delete;
  ~HelperProcess();

  /// The payload of the next message, which is of this kind; none at the end. Throws what the helper sent, and an InputError
  /// with the library's name where it sent something else or ended.
  [[nodiscard]] std::optional<std::string> receive(HelperMessageKind expected);
  [[noreturn]] void fail_of_library(const std::string& how) const;

 private:
  void start(const HelperCommand& command);
  void receive_bytes(void* data, std::size_t bytes);
  std::string how_it_ended();
  void stop();
  [[noreturn]] void fail(const std::string& what, int error) const;

  std::string name_;
  std::string library_;
  pid_t child_ = -1;
  int pipe_ = -1;
};

}  // namespace saccade
