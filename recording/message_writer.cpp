#include "recording/message_writer.h"

#include <algorithm>

#include "core/error.h"
#include "recording/codec.h"

namespace saccade {
namespace {

constexpr std::size_t most_events = 8192;
constexpr std::int64_t longest_us = 10'000;

}  // namespace

void MessageWriter::write(std::span<const Event> events) {
  for (const Event& event : events) {
    check_writable(event, image_size_, 1, file_.path());
    if (event.t_us < 0 || event.t_us > largest_us_) {
      throw InputError(file_.path().string(), "an event at " + std::to_string(event.t_us) + " us",
                       "times from 0 to " + std::to_string(largest_us_) +
                           " us; --zero-time of saccade convert begins at 0");
    }
    if (!pending_.empty()) {
      const std::int64_t after_us = event.t_us - pending_.front().t_us;
      if (pending_.size() == most_events || after_us < 0 || after_us > longest_us) flush();
    }
    pending_.push_back(event);
  }
}

void MessageWriter::sync() {
  flush();
  put_chunk();
  file_.sync();
}

void MessageWriter::commit() {
  flush();
  finish();
  file_.commit();
}

void MessageWriter::flush() {
  if (pending_.empty()) return;
  const std::int64_t last_us = std::ranges::max_element(pending_, {}, &Event::t_us)->t_us;
  put_message(pending_, seq_++, static_cast<std::uint64_t>(last_us) * 1000);
  pending_.clear();
}

void check_packet_size(const std::filesystem::path& path, ImageSize image_size) {
  constexpr int most_rows = 1 << 15;
  if (image_size.height <= most_rows) return;
  throw InputError(path.string(), "an image of " + text_of(image_size),
                   "at most " + std::to_string(most_rows) + " rows for EventPacket");
}

}  // namespace saccade
