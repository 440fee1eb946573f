#include "recording/helper_reader.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <system_error>
#include <vector>

#include "core/error.h"
#include "recording/helper_protocol.h"
#include "recording/module_path.h"
#include "recording/spawn_settings.h"

namespace saccade {
namespace {

class HelperReader final : public EventReader {
 public:
  HelperReader(std::string name, std::string library, const HelperCommand& command)
      : name_(std::move(name)), library_(std::move(library)) {
    start(command);
    try {
      HelperImageSize size{};
      const std::string opened = receive(HelperMessageKind::opened);
      if (opened.size() < sizeof size) fail_of_library("(bad message)");
      std::memcpy(&size, opened.data(), sizeof size);
      if (size.width > 0 && size.height > 0) image_size_ = ImageSize{size.width, size.height};
      format_ = opened.substr(sizeof size);
    } catch (...) {
      stop();
      throw;
    }
  }
  ~HelperReader() override { stop(); }
  HelperReader(const HelperReader&) = delete;
  HelperReader& operator=(const HelperReader&) = delete;

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
  void start(const HelperCommand& command) {
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

  /// False at the end; where the file is broken false too, as long as there are events to return first.
  bool next_block(bool has_events) {
    block_.clear();
    next_ = 0;
    if (failure_ && !has_events) throw InputError(*failure_);
    if (failure_ || ended_) return false;
    try {
      take_events(receive(HelperMessageKind::events));
    } catch (const InputError& error) {
      failure_ = error;
      if (!has_events) throw;
    }
    return !block_.empty();
  }

  void take_events(const std::string& bytes) {
    for (std::size_t i = 0; i + sizeof(HelperEvent) <= bytes.size(); i += sizeof(HelperEvent)) {
      HelperEvent sent;
      std::memcpy(&sent, bytes.data() + i, sizeof sent);
      block_.push_back({sent.t_us, sent.x, sent.y, sent.on != 0, sent.camera});
    }
  }

  /// The payload of the next message, which is of this kind or the end; throws what the helper sent.
  std::string receive(HelperMessageKind expected) {
    HelperMessage head;
    receive_bytes(&head, sizeof head);
    if (head.bytes > helper_block_events * sizeof(HelperEvent)) fail_of_library("(bad message)");
    std::string payload(head.bytes, '\0');
    receive_bytes(payload.data(), payload.size());
    if (head.kind == expected) return payload;
    if (head.kind == HelperMessageKind::end) {
      ended_ = true;
      return {};
    }
    if (head.kind == HelperMessageKind::failure) throw RunError(payload);
    const std::size_t value = payload.find('\0') + 1;
    const std::size_t expectation = payload.find('\0', value) + 1;
    if (head.kind != HelperMessageKind::bad_input || value == 0 || expectation == 0) {
      fail_of_library("(bad message)");
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
      if (WTERMSIG(status) == SIGALRM) return "(time limit)";
      return "(signal " + std::to_string(WTERMSIG(status)) + ")";
    }
    return done > 0 ? "(exit status " + std::to_string(WEXITSTATUS(status)) + ")" : "(no exit status)";
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
  [[noreturn]] void fail(const std::string& what, int error) const {
    throw RunError(name_ + ": " + what + ": " + std::generic_category().message(error));
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

std::unique_ptr<EventReader> open_in_helper(const std::string& name, const std::string& library,
                                            const HelperCommand& command) {
  return std::make_unique<HelperReader>(name, library, command);
}

std::filesystem::path find_helper(std::string_view file_name) {
  namespace fs = std::filesystem;
  constexpr const char* below_prefix = "libexec/saccade";
  const fs::path own_folder = module_path().parent_path();
  std::vector<fs::path> folders = {own_folder};
  for (fs::path above = own_folder; above.has_relative_path(); above = above.parent_path()) {
    std::error_code ignored;
    if (const fs::path folder = above.parent_path() / below_prefix; fs::is_directory(folder, ignored))
      folders.push_back(folder);
  }
  if (const char* const data = std::getenv("SACCADE_DATA"); data != nullptr && *data != '\0')
    folders.push_back(fs::path(data) / "../.." / below_prefix);
  folders.insert(folders.end(), {SACCADE_LIBEXEC_DIR, SACCADE_BUILD_BIN_DIR});
  std::string searched;
  for (const fs::path& folder : folders) {
    const fs::path file = folder / file_name;
    if (::access(file.c_str(), R_OK) == 0) return file;
    searched += (searched.empty() ? "" : ", ") + folder.string();
  }
  throw RunError("the file " + std::string(file_name) + " is missing; searched in " + searched);
}

}  // namespace saccade
