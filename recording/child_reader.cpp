#include "recording/child_reader.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <span>
#include <system_error>

#include "core/error.h"

namespace saccade {
namespace {

constexpr std::size_t block_events = 1 << 14;

enum class Kind : std::uint32_t { opened, events, end, bad_input, failure };

/// Every message begins with it.
struct Head {
  Kind kind = Kind::end;
  std::uint32_t bytes = 0;
};

/// An event without a byte that may not have every value: a child whose memory is spoilt may send anything.
struct WireEvent {
  std::int64_t t_us;
  std::uint16_t x;
  std::uint16_t y;
  std::uint8_t on;
  std::uint8_t camera;
  std::uint16_t unused;
};

struct WireSize {
  std::int32_t width;
  std::int32_t height;  ///< both 0 where the file does not tell
};

// ---- the child -----------------------------------------------------------------------------------

void send_bytes(int pipe, const void* data, std::size_t bytes) {
  const char* at = static_cast<const char*>(data);
  while (bytes > 0) {
    const ssize_t n = ::write(pipe, at, bytes);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) ::_exit(1);
    at += n;
    bytes -= static_cast<std::size_t>(n);
  }
}

void send(int pipe, Kind kind, std::string_view payload) {
  const Head head{kind, static_cast<std::uint32_t>(payload.size())};
  send_bytes(pipe, &head, sizeof head);
  send_bytes(pipe, payload.data(), payload.size());
}

void send_events(int pipe, std::span<const Event> events) {
  static_assert(sizeof(WireEvent) == 16);
  std::array<WireEvent, block_events> wire;
  for (std::size_t i = 0; i < events.size(); ++i) {
    const Event& e = events[i];
    wire[i] = {e.t_us, e.x, e.y, static_cast<std::uint8_t>(e.on ? 1 : 0), e.camera, 0};
  }
  send(pipe, Kind::events, {reinterpret_cast<const char*>(wire.data()), events.size() * sizeof(WireEvent)});
}

void read_all_for_parent(int pipe, const std::function<std::unique_ptr<EventReader>()>& open,
                         unsigned patience_s) {
  ::alarm(patience_s);
  const std::unique_ptr<EventReader> reader = open();
  const ImageSize size = reader->image_size().value_or(ImageSize{0, 0});
  const WireSize wire{size.width, size.height};
  send(pipe, Kind::opened,
       std::string(reinterpret_cast<const char*>(&wire), sizeof wire).append(reader->format()));
  std::vector<Event> block;
  for (;;) {
    block.clear();
    ::alarm(patience_s);
    const std::size_t count = reader->read(block, block_events);
    ::alarm(0);  // the parent may take its time
    if (count == 0) break;
    send_events(pipe, block);
  }
  send(pipe, Kind::end, {});
}

/// Nothing of the parent's is closed, flushed or destroyed here.
[[noreturn]] void live_as_child(int pipe, const std::function<std::unique_ptr<EventReader>()>& open,
                                unsigned patience_s) {
  for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGALRM, SIGPIPE, SIGTERM}) {
    std::signal(signal, SIG_DFL);
  }
  std::signal(SIGINT, SIG_IGN);  // the parent decides when it is over
  const rlimit no_core{0, 0};
  ::setrlimit(RLIMIT_CORE, &no_core);
  if (pipe > 3) ::close_range(3, static_cast<unsigned>(pipe) - 1, 0);
  ::close_range(static_cast<unsigned>(pipe) + 1, ~0U, 0);
  // A library that dies may say so; the parent says it better.
  if (const int nowhere = ::open("/dev/null", O_WRONLY); nowhere >= 0) ::dup2(nowhere, STDERR_FILENO);
  try {
    read_all_for_parent(pipe, open, patience_s);
  } catch (const InputError& error) {
    const Problem& problem = error.problems().front();
    send(pipe, Kind::bad_input, problem.place + '\0' + problem.value + '\0' + problem.expectation);
  } catch (const std::exception& error) {
    send(pipe, Kind::failure, error.what());
  }
  ::_exit(0);
}

// ---- the parent ----------------------------------------------------------------------------------

class ChildReader final : public EventReader {
 public:
  ChildReader(const std::string& name, const std::string& library,
              const std::function<std::unique_ptr<EventReader>()>& open, unsigned patience_s)
      : name_(name), library_(library) {
    std::array<int, 2> ends{};
    if (::pipe(ends.data()) != 0) fail("no pipe to a child process");
    child_ = ::fork();
    if (child_ == 0) live_as_child(ends[1], open, patience_s);
    ::close(ends[1]);
    pipe_ = ends[0];
    try {
      if (child_ < 0) fail("no child process to read it in");
      WireSize size{};
      const std::string hello = receive(Kind::opened);
      if (hello.size() < sizeof size) fail_of_library("(no sense in what it says)");
      std::memcpy(&size, hello.data(), sizeof size);
      if (size.width > 0 && size.height > 0) image_size_ = ImageSize{size.width, size.height};
      format_ = hello.substr(sizeof size);
    } catch (...) {
      stop();
      throw;
    }
  }
  ~ChildReader() override { stop(); }
  ChildReader(const ChildReader&) = delete;
  ChildReader& operator=(const ChildReader&) = delete;

  std::size_t read(std::vector<Event>& events, std::size_t max_events) override {
    std::size_t count = 0;
    while (count < max_events) {
      if (next_ == block_.size() && !next_block(count > 0)) break;
      const std::size_t more = std::min(block_.size() - next_, max_events - count);
      const auto first = block_.begin() + static_cast<std::ptrdiff_t>(next_);
      events.insert(events.end(), first, first + static_cast<std::ptrdiff_t>(more));
      next_ += more;
      count += more;
    }
    return count;
  }
  std::optional<ImageSize> image_size() const override { return image_size_; }
  std::string format() const override { return format_; }

 private:
  /// False at the end; where the file is broken false too, as long as there are events to return first.
  bool next_block(bool has_events) {
    block_.clear();
    next_ = 0;
    if (failure_ && !has_events) throw InputError(*failure_);
    if (failure_ || ended_) return false;
    try {
      take_events(receive(Kind::events));
    } catch (const InputError& error) {
      failure_ = error;
      if (!has_events) throw;
    }
    return !block_.empty();
  }

  void take_events(const std::string& bytes) {
    for (std::size_t i = 0; i + sizeof(WireEvent) <= bytes.size(); i += sizeof(WireEvent)) {
      WireEvent wire;
      std::memcpy(&wire, bytes.data() + i, sizeof wire);
      block_.push_back({wire.t_us, wire.x, wire.y, wire.on != 0, wire.camera});
    }
  }

  /// The payload of the next message, which is of this kind or the end; throws what the child threw.
  std::string receive(Kind expected) {
    Head head;
    receive_bytes(&head, sizeof head);
    if (head.bytes > block_events * sizeof(WireEvent)) fail_of_library("(no sense in what it says)");
    std::string payload(head.bytes, '\0');
    receive_bytes(payload.data(), payload.size());
    if (head.kind == expected) return payload;
    if (head.kind == Kind::end) {
      ended_ = true;
      return {};
    }
    if (head.kind == Kind::failure) throw RunError(payload);
    const std::size_t value = payload.find('\0') + 1;
    const std::size_t expectation = payload.find('\0', value) + 1;
    if (head.kind != Kind::bad_input || value == 0 || expectation == 0) {
      fail_of_library("(no sense in what it says)");
    }
    throw InputError(payload.substr(0, value - 1), payload.substr(value, expectation - value - 1),
                     payload.substr(expectation));
  }

  void receive_bytes(void* data, std::size_t bytes) {
    char* at = static_cast<char*>(data);
    while (bytes > 0) {
      const ssize_t n = ::read(pipe_, at, bytes);
      if (n < 0 && errno == EINTR) continue;
      if (n <= 0) fail_of_library(how_it_ended());
      at += n;
      bytes -= static_cast<std::size_t>(n);
    }
  }

  std::string how_it_ended() {
    int status = 0;
    pid_t done = 0;
    do {
      done = ::waitpid(child_, &status, 0);
    } while (done < 0 && errno == EINTR);
    child_ = -1;
    if (done > 0 && WIFSIGNALED(status)) {
      if (WTERMSIG(status) == SIGALRM) return "(it found no end)";
      return "(signal " + std::to_string(WTERMSIG(status)) + ")";
    }
    return done > 0 ? "(exit status " + std::to_string(WEXITSTATUS(status)) + ")" : "(it is gone)";
  }

  void stop() {
    if (child_ > 0) {
      ::kill(child_, SIGKILL);
      (void)how_it_ended();
    }
    if (pipe_ >= 0) ::close(pipe_);
    pipe_ = -1;
  }

  [[noreturn]] void fail_of_library(const std::string& how) const {
    throw InputError(name_, "a file on which " + library_ + " failed " + how, "a sound file");
  }
  [[noreturn]] void fail(const std::string& what) const {
    throw RunError(name_ + ": " + what + ": " + std::generic_category().message(errno));
  }

  std::string name_;
  std::string library_;
  pid_t child_ = -1;
  int pipe_ = -1;
  std::optional<ImageSize> image_size_;
  std::string format_;
  std::vector<Event> block_;
  std::size_t next_ = 0;
  bool ended_ = false;
  std::optional<InputError> failure_;
};

}  // namespace

std::unique_ptr<EventReader> open_in_child(const std::string& name, const std::string& library,
                                           const std::function<std::unique_ptr<EventReader>()>& open,
                                           unsigned patience_s) {
  return std::make_unique<ChildReader>(name, library, open, patience_s);
}

}  // namespace saccade
