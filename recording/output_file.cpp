#include "recording/output_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <condition_variable>
#include <cstdio>
#include <deque>
#include <mutex>
#include <string>
#include <system_error>
#include <thread>

namespace saccade {
namespace {

constexpr std::size_t block_bytes = std::size_t{1} << 16;
constexpr std::size_t waiting_blocks = 64;

[[noreturn]] void fail(const std::filesystem::path& path, const char* what, int cause = errno) {
  const std::string message = path.string() + ": " + what + ": " + std::generic_category().message(cause);
  if (cause == ENOSPC || cause == EDQUOT || cause == EFBIG) throw DiskFull(message);
  throw RunError(message);
}

/// Returns 0, or the errno of the failure.
int write_all(int file, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t count = ::write(file, bytes.data(), bytes.size());
    if (count < 0 && errno != EINTR) return errno;
    bytes = bytes.subspan(static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
  }
  return 0;
}

}  // namespace

/// Writes blocks in their order. After a failure it discards what follows.
class OutputFile::WriterThread {
 public:
  explicit WriterThread(int file) : file_(file), thread_([this] { run(); }) {}
  ~WriterThread() {
    {
      const std::lock_guard lock(mutex_);
      over_ = true;
      waiting_.clear();
    }
    changed_.notify_all();
    thread_.join();
  }

  /// Takes the content of `block`, which is empty afterwards; waits while too much is waiting. Returns 0, or the errno of
  /// a failure so far, as does wait().
  int add(std::vector<std::byte>& block) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return waiting_.size() < waiting_blocks; });
    waiting_.push_back(std::move(block));
    block.clear();
    if (!spare_.empty()) {
      block.swap(spare_.back());
      spare_.pop_back();
    }
    changed_.notify_all();
    return failure_;
  }
  /// Waits until everything is written.
  int wait() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return waiting_.empty() && !writes_; });
    return failure_;
  }

 private:
  void run() {
    std::unique_lock lock(mutex_);
    for (;;) {
      changed_.wait(lock, [&] { return over_ || !waiting_.empty(); });
      if (over_) return;
      std::vector<std::byte> block = std::move(waiting_.front());
      waiting_.pop_front();
      writes_ = true;
      const bool works = failure_ == 0;
      lock.unlock();
      const int failure = works ? write_all(file_, block) : 0;
      block.clear();
      lock.lock();
      if (works) failure_ = failure;
      spare_.push_back(std::move(block));
      writes_ = false;
      changed_.notify_all();
    }
  }

  int file_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::vector<std::byte>> waiting_;
  std::vector<std::vector<std::byte>> spare_;  // empty blocks, whose memory is used again
  bool writes_ = false;
  bool over_ = false;
  int failure_ = 0;
  std::thread thread_;
};

void check_outputs(std::span<const std::filesystem::path> outputs,
                   std::span<const std::filesystem::path> inputs, bool force) {
  namespace fs = std::filesystem;
  for (const fs::path& output : outputs) {
    std::error_code error;
    for (const fs::path& input : inputs) {
      fs::path part = output;
      part += ".part";
      if (fs::equivalent(output, input, error) || fs::equivalent(part, input, error)) {
        throw InputError(output.string(), "the file that is read, " + input.string(), "another name");
      }
    }
    if (fs::is_directory(output, error)) {
      throw InputError(output.string(), "a folder", "the name of a file to write");
    }
    if (!force && fs::exists(output, error)) {
      throw InputError(output.string(), "a file that exists", "another name, or --force to replace it");
    }
  }
}

OutputFile::OutputFile(std::filesystem::path path) : path_(std::move(path)), part_(path_) {
  part_ += ".part";
  file_ = ::open(part_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (file_ < 0) fail(path_, "cannot be created");
}

OutputFile::~OutputFile() {
  if (file_ < 0) return;
  try {
    if (keeps_part_) wait_until_written();
  } catch (const RunError&) {  // what could not be written is missing at the end of the .part file
  }
  thread_.reset();
  ::close(file_);
  if (!keeps_part_) std::remove(part_.c_str());
}

void OutputFile::write(std::span<const std::byte> bytes) {
  SACCADE_CHECK(file_ >= 0);
  while (!bytes.empty()) {
    const std::size_t count = std::min(bytes.size(), block_bytes - buffer_.size());
    buffer_.insert(buffer_.end(), bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(count));
    bytes = bytes.subspan(count);
    if (buffer_.size() == block_bytes) write_buffer();
  }
}

void OutputFile::write(std::string_view text) { write(std::as_bytes(std::span(text))); }

void OutputFile::write_buffer() {
  if (!thread_) thread_ = std::make_unique<WriterThread>(file_);
  if (const int failure = thread_->add(buffer_)) fail(path_, "cannot be written", failure);
}

void OutputFile::wait_until_written() {
  if (thread_) {
    if (const int failure = thread_->wait()) fail(path_, "cannot be written", failure);
  }
  if (const int failure = write_all(file_, buffer_)) fail(path_, "cannot be written", failure);
  buffer_.clear();
}

void OutputFile::overwrite(std::int64_t offset, std::span<const std::byte> bytes) {
  SACCADE_CHECK(file_ >= 0);
  wait_until_written();
  if (::lseek(file_, offset, SEEK_SET) < 0) fail(path_, "cannot be written");
  if (const int failure = write_all(file_, bytes)) fail(path_, "cannot be written", failure);
  if (::lseek(file_, 0, SEEK_END) < 0) fail(path_, "cannot be written");
}

void OutputFile::sync() {
  SACCADE_CHECK(file_ >= 0);
  keeps_part_ = true;
  wait_until_written();
  if (::fdatasync(file_) != 0) fail(path_, "cannot be written");
}

void OutputFile::commit() {
  SACCADE_CHECK(file_ >= 0);
  wait_until_written();
  if (::fsync(file_) != 0) fail(path_, "cannot be written");
  if (std::rename(part_.c_str(), path_.c_str()) != 0) fail(path_, "cannot be created");
  thread_.reset();
  ::close(file_);
  file_ = -1;
}

void write_file(const std::filesystem::path& path, std::string_view text) {
  OutputFile file(path);
  file.write(text);
  file.commit();
}

}  // namespace saccade
