#include "recording/helper_process.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <system_error>
#include <vector>

#include "core/error.h"
#include "recording/helper_reader.h"
#include "recording/spawn_settings.h"

namespace saccade {

HelperProcess::HelperProcess(std::string name, std::string library, const HelperCommand& command)
    : name_(std::move(name)), library_(std::move(library)) {
  start(command);
}

HelperProcess::~HelperProcess() { stop(); }

void HelperProcess::start(const HelperCommand& command) {
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) fail("no pipe to a helper process", errno);
  SpawnSettings settings;
  settings.use_nothing(STDIN_FILENO);
  settings.use(ends[1], STDOUT_FILENO);
  // A library that aborts prints why; the error message of the recording replaces that.
  settings.use_nothing(STDERR_FILENO);
  std::vector<std::string> words = {command.program.string()};
  words.insert(words.end(), command.arguments.begin(), command.arguments.end());
  const int error = settings.start(words, child_);
  ::close(ends[1]);
  pipe_ = ends[0];
  if (error == 0) return;
  child_ = -1;
  stop();
  fail("cannot start the helper process " + words[0], error);
}

std::optional<std::string> HelperProcess::receive(HelperMessageKind expected) {
  HelperMessage head;
  receive_bytes(&head, sizeof head);
  if (head.bytes > helper_most_bytes) fail_of_library("(bad message)");
  std::string payload(head.bytes, '\0');
  receive_bytes(payload.data(), payload.size());
  if (head.kind == expected) return payload;
  if (head.kind == HelperMessageKind::end) return std::nullopt;
  if (head.kind == HelperMessageKind::failure) throw RunError(payload);
  const std::size_t value = payload.find('\0') + 1;
  const std::size_t expectation = payload.find('\0', value) + 1;
  if (head.kind != HelperMessageKind::bad_input || value == 0 || expectation == 0) {
    fail_of_library("(bad message)");
  }
  throw InputError(payload.substr(0, value - 1), payload.substr(value, expectation - value - 1),
                   payload.substr(expectation));
}

void HelperProcess::receive_bytes(void* data, std::size_t bytes) {
  char* at = static_cast<char*>(data);
  while (bytes > 0) {
    const ssize_t n = ::read(pipe_, at, bytes);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) fail_of_library(how_it_ended());
    at += n;
    bytes -= static_cast<std::size_t>(n);
  }
}

std::string HelperProcess::how_it_ended() {
  int status = 0;
  pid_t done = 0;
  do {
    done = ::waitpid(child_, &status, 0);
  } while (done < 0 && errno == EINTR);
  child_ = -1;
  if (done > 0 && WIFSIGNALED(status)) {
    if (WTERMSIG(status) == SIGALRM) return "(time limit)";
    return "(signal " + std::to_string(WTERMSIG(status)) + ")";
  }
  return done > 0 ? "(exit status " + std::to_string(WEXITSTATUS(status)) + ")" : "(no exit status)";
}

void HelperProcess::stop() {
  if (child_ > 0) {
    ::kill(child_, SIGKILL);
    (void)how_it_ended();
  }
  if (pipe_ >= 0) ::close(pipe_);
  pipe_ = -1;
}

void HelperProcess::fail_of_library(const std::string& how) const {
  throw InputError(name_, "a file on which " + library_ + " failed " + how, "a sound file");
}

void HelperProcess::fail(const std::string& what, int error) const {
  throw RunError(name_ + ": " + what + ": " + std::generic_category().message(error));
}

}  // namespace saccade
