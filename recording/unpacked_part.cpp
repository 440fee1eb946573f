#include "recording/unpacked_part.h"

#include <zlib.h>

#include <span>
#include <utility>

#include "core/error.h"

namespace saccade {

void UnpackedPart::begin(std::unique_ptr<Decompressor> decompressor, std::uint64_t stored_bytes) {
  decompressor_ = std::move(decompressor);
  decompressor_->begin();
  stored_left_ = stored_bytes;
  begin_ = end_ = 0;
  crc_ = 0;
}

std::string_view UnpackedPart::peek(std::size_t wanted) {
  SACCADE_CHECK(wanted <= window_.size());
  if (end_ - begin_ < wanted) {
    std::copy(window_.begin() + static_cast<std::ptrdiff_t>(begin_),
              window_.begin() + static_cast<std::ptrdiff_t>(end_), window_.begin());
    end_ -= begin_;
    begin_ = 0;
    while (end_ < wanted && decompressor_ && (stored_left_ > 0 || decompressor_->unfinished())) unpack();
  }
  return {window_.data() + begin_, end_ - begin_};
}

void UnpackedPart::unpack() {
  const std::string_view ahead = stored_left_ > 0 ? file_.peek(1).substr(0, stored_left_) : "";
  const Decompressor::Step step = decompressor_->run(ahead, std::span(window_).subspan(end_));
  if (step.error != nullptr) fail(step.error, "a part that can be unpacked");
  file_.skip(step.read);
  stored_left_ -= step.read;
  end_ += step.written;
  if (step.read > 0 || step.written > 0) return;
  if (stored_left_ > 0 && ahead.empty()) fail("the end of the file", "the rest of a compressed part");
  fail("compressed data without its end", "a part that can be unpacked");
}

void UnpackedPart::skip(std::size_t count) {
  SACCADE_CHECK(count <= end_ - begin_);
  crc_ = static_cast<std::uint32_t>(
      crc32(crc_, reinterpret_cast<const Bytef*>(window_.data() + begin_), static_cast<uInt>(count)));
  begin_ += count;
}

bool UnpackedPart::discard(std::uint64_t count) { return skip_bytes(*this, count); }

bool UnpackedPart::discard_rest() {
  const std::uint64_t left = std::exchange(stored_left_, 0);
  decompressor_.reset();
  begin_ = end_ = 0;
  return file_.discard(left);
}

void UnpackedPart::fail(std::string value, std::string expectation) const {
  file_.fail(std::move(value), std::move(expectation));
}

}  // namespace saccade
