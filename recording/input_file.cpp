#include "recording/input_file.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>

#include "core/error.h"

namespace saccade {
namespace {

constexpr std::size_t buffer_bytes = 1 << 20;
constexpr std::size_t piece_bytes = 1 << 16;  // what is read at a time stays in the processor's cache

}  // namespace

InputFile::InputFile(std::filesystem::path path) : path_(std::move(path)), buffer_(new char[buffer_bytes]) {
  const std::string expectation = "a recording";
  std::error_code error;
  if (std::filesystem::is_directory(path_, error)) throw InputError(name(), "a directory", expectation);
  file_.reset(std::fopen(path_.c_str(), "rb"));
  if (!file_) throw InputError(name(), std::generic_category().message(errno), expectation);
  std::setvbuf(file_.get(), nullptr, _IONBF, 0);
  if (std::filesystem::is_regular_file(path_, error)) {
    const auto bytes = std::filesystem::file_size(path_, error);
    if (!error) size_ = bytes;
  }
  if (peek(1).empty()) throw InputError(name(), "an empty file", expectation);
}

std::string_view InputFile::peek(std::size_t wanted) {
  SACCADE_CHECK(wanted <= buffer_bytes);
  if (end_ - begin_ < wanted) {
    std::memmove(buffer_.get(), buffer_.get() + begin_, end_ - begin_);
    end_ -= begin_;
    begin_ = 0;
    const std::size_t piece = std::min(std::max(wanted - end_, piece_bytes), buffer_bytes - end_);
    end_ += std::fread(buffer_.get() + end_, 1, piece, file_.get());
    if (std::ferror(file_.get()) != 0) {
      throw InputError(name() + ": byte " + std::to_string(offset_ + end_), "a read error",
                       "a readable file");
    }
  }
  return {buffer_.get() + begin_, end_ - begin_};
}

void InputFile::skip(std::size_t count) {
  SACCADE_CHECK(count <= end_ - begin_);
  begin_ += count;
  offset_ += count;
}

bool InputFile::discard(std::uint64_t count) {
  const std::size_t buffered = end_ - begin_;
  if (count > buffered && size_ && count <= *size_ - std::min(*size_, offset_) &&
      ::fseeko(file_.get(), static_cast<off_t>(count - buffered), SEEK_CUR) == 0) {
    begin_ = end_ = 0;
    offset_ += count;
    return true;
  }
  return skip_bytes(*this, count);
}

void InputFile::fail(std::string value, std::string expectation) const {
  throw InputError(name() + ": byte " + std::to_string(offset_), std::move(value), std::move(expectation));
}

}  // namespace saccade
