#include "external/line_process.h"

#include <poll.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <thread>

#include "core/error.h"
#include "recording/spawn_settings.h"

namespace saccade {
namespace {

using WallClock = std::chrono::steady_clock;

std::string how_ended(int status) {
  if (WIFSIGNALED(status)) {
    const int signal = WTERMSIG(status);
    return "by signal " + std::to_string(signal) + " (" + ::strsignal(signal) + ")";
  }
  return "with status " + std::to_string(WEXITSTATUS(status));
}

}  // namespace

LineProcess::LineProcess(const Place& place, std::chrono::milliseconds limit) {
  if (const auto* address = std::get_if<SocketAddress>(&place)) {
    peer_ = text_of(*address);
    socket_ = connect_to(*address, limit);
  } else {
    start(std::get<ProgramCall>(place));
  }
}

void LineProcess::start(const ProgramCall& call) {
  std::array<int, 2> ends{};
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0)
    throw RunError(std::string("no socket to a program: ") + std::strerror(errno));
  socket_ = ends[0];
  SpawnSettings settings;
  settings.use(ends[1], STDIN_FILENO);
  settings.use(ends[1], STDOUT_FILENO);
  settings.own_process_group();  // an interrupt from the keyboard ends the run first
  if (!call.folder.empty()) settings.work_in(call.folder);
  const int error = settings.start(call.words, child_);
  ::close(ends[1]);
  if (error == 0) return;
  child_ = -1;
  close_socket();
  throw RunError("cannot start " + call.words[0] + ": " + std::strerror(error));
}

LineProcess::~LineProcess() {
  end(std::chrono::milliseconds(200));
  while (child_ >= 0 && ::waitpid(child_, nullptr, 0) < 0 && errno == EINTR) {
  }
}

void LineProcess::close_socket() {
  if (socket_ >= 0) ::close(socket_);
  socket_ = -1;
}

LineProcess::Status LineProcess::take_line(std::string& answer) {
  const std::size_t end = received_.find('\n');
  if (end == std::string::npos) return received_.size() > longest_line ? Status::endless : Status::late;
  if (end > longest_line) return Status::endless;
  answer.assign(received_, 0, end);
  received_.erase(0, end + 1);
  return Status::ok;
}

LineProcess::Status LineProcess::exchange(std::string_view message, std::chrono::milliseconds limit,
                                          std::string& answer) {
  if (!received_.empty()) return Status::unasked;
  const WallClock::time_point deadline = WallClock::now() + limit;
  while (true) {
    // A late status means that the line is not complete yet.
    if (message.empty()) {
      const Status status = take_line(answer);
      if (status != Status::late) return status;
    }
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - WallClock::now());
    if (left.count() <= 0) return Status::late;
    pollfd wait{socket_, static_cast<short>(message.empty() ? POLLIN : POLLIN | POLLOUT), 0};
    const int ready = ::poll(&wait, 1, static_cast<int>(left.count()));
    if (ready <= 0) continue;  // the time limit, or a signal
    if ((wait.revents & POLLOUT) != 0) {
      const ssize_t sent = ::send(socket_, message.data(), message.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
      if (sent > 0) message.remove_prefix(static_cast<std::size_t>(sent));
      if (sent < 0 && errno != EAGAIN && errno != EINTR) return Status::ended;
    }
    if ((wait.revents & (POLLIN | POLLHUP | POLLERR)) != 0) {
      std::array<char, 4096> block;
      const ssize_t count = ::recv(socket_, block.data(), block.size(), MSG_DONTWAIT);
      if (count == 0 || (count < 0 && errno != EAGAIN && errno != EINTR)) return Status::ended;
      if (count > 0) received_.append(block.data(), static_cast<std::size_t>(count));
      if (received_.size() > 2 * longest_line) return Status::endless;
    }
  }
}

std::string LineProcess::end(std::chrono::milliseconds patience) {
  close_socket();
  if (!peer_.empty()) return "its connection to " + peer_ + " is closed";
  if (child_ < 0) return {};
  // The end of its standard input ends a well-behaved program.
  const WallClock::time_point deadline = WallClock::now() + patience;
  int status = 0;
  pid_t ended = 0;
  while ((ended = ::waitpid(child_, &status, WNOHANG)) == 0 && WallClock::now() < deadline)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  ::kill(-child_, SIGKILL);  // and what it has started
  if (ended == 0) return {};
  child_ = -1;
  return ended > 0 ? how_ended(status) : std::string();
}

}  // namespace saccade
