#include "recording/input_file.h"

#include <cerrno>
#include <cstring>
#include <system_error>

#include "core/error.h"

namespace saccade {
namespace {

constexpr std::size_t buffer_bytes = 1 << 20;

}  // namespace

InputFile::InputFile(std::filesystem::path path) : path_(std::move(path)), buffer_(buffer_bytes) {
  const std::string expectation = "a recording";
  std::error_code error;
  if (std::filesystem::is_directory(path_, error)) throw InputError(name(), "a directory", expectation);
  file_.reset(std::fopen(path_.c_str(), "rb"));
  if (!file_) throw InputError(name(), std::generic_category().message(errno), expectation);
  std::setvbuf(file_.get(), nullptr, _IONBF, 0);
  if (peek(1).empty()) throw InputError(name(), "an empty file", expectation);
}

std::string_view InputFile::peek(std::size_t wanted) {
  SACCADE_CHECK(wanted <= buffer_.size());
  if (end_ - begin_ < wanted) {
    std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
    end_ -= begin_;
    begin_ = 0;
    end_ += std::fread(buffer_.data() + end_, 1, buffer_.size() - end_, file_.get());
    if (std::ferror(file_.get()) != 0) {
      throw InputError(name() + ": byte " + std::to_string(offset_ + end_), "a read error",
                       "a readable file");
    }
  }
  return {buffer_.data() + begin_, end_ - begin_};
}

void InputFile::skip(std::size_t count) {
  SACCADE_CHECK(count <= end_ - begin_);
  begin_ += count;
  offset_ += count;
}

}  // namespace saccade
