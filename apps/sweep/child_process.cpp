#include "apps/sweep/child_process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>

#include "core/error.h"
#include "recording/output_file.h"

namespace saccade {
namespace {

constexpr std::size_t longest_why = 4096;  // a pipe holds more without a reader

/// The child's side: its last words go to standard error, after all output, and into the pipe `why`.
int status_of(const std::function<int()>& work, int why) {
  const auto report = [&](const std::exception& error) {
    const std::string_view text = error.what();
    std::fflush(stdout);
    fmt::print(stderr, "{}\n", text);
    [[maybe_unused]] const ssize_t count = ::write(why, text.data(), std::min(text.size(), longest_why));
  };
  try {
    return work();
  } catch (const DiskFull& error) {
    report(error);
    return disk_full_status;
  } catch (const InputError& error) {
    report(error);
    return 2;
  } catch (const std::exception& error) {
    report(error);
    return 1;
  }
}

std::string last_line(const std::filesystem::path& log) {
  std::ifstream file(log);
  std::string last;
  for (std::string line; std::getline(file, line);)
    if (!line.empty()) last = line;
  return last;
}

}  // namespace

void die_with_parent(pid_t parent) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(1);
}

ChildEnd run_in_child(int log, const std::function<int()>& work) {
  std::fflush(nullptr);
  std::array<int, 2> why{};
  if (::pipe2(why.data(), O_CLOEXEC | O_NONBLOCK) != 0)
    throw RunError(std::string("cannot make a pipe: ") + std::strerror(errno));
  const pid_t parent = ::getpid();
  const pid_t child = ::fork();
  if (child < 0) {
    for (const int end : why) ::close(end);
    throw RunError(std::string("cannot start a process: ") + std::strerror(errno));
  }
  if (child == 0) {
    die_with_parent(parent);
    ::dup2(log, STDOUT_FILENO);
    ::dup2(log, STDERR_FILENO);
    const int status = status_of(work, why[1]);
    std::fflush(nullptr);
    ::_exit(status);
  }
  ChildEnd end;
  while (::waitpid(child, &end.status, 0) < 0 && errno == EINTR) {
  }
  std::array<char, longest_why> text;
  const ssize_t count = ::read(why[0], text.data(), text.size());
  if (count > 0) end.why.assign(text.data(), static_cast<std::size_t>(count));
  for (const int side : why) ::close(side);
  return end;
}

bool was_stopped(int status) {
  if (!WIFSIGNALED(status)) return false;
  const int number = WTERMSIG(status);
  return number == SIGKILL || number == SIGTERM || number == SIGINT || number == SIGHUP;
}

std::string failure_text(const ChildEnd& end, const std::filesystem::path& log) {
  std::string text = end.why.empty() ? last_line(log) : end.why;
  for (std::size_t at = text.find('\n'); at != std::string::npos; at = text.find('\n', at))
    text.replace(at, 1, "; ");
  return WIFSIGNALED(end.status) ? fmt::format("ended by signal {}: {}", WTERMSIG(end.status), text) : text;
}

}  // namespace saccade
