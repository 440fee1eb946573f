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
    check_writable(event, image_size_, cameras_, file_.path());
    if (event.t_us < 0 || event.t_us > largest_us_) {
      throw InputError(
          file_.path().string(), "an event at " + std::to_string(event.t_us) + " us",
          "times from 0 to " + std::to_string(largest_us_) + " us; " + std::string(zero_time_hint));
    }
    for (int camera = 0; camera < cameras_; ++camera) {
      const std::vector<Event>& pending = sides_[static_cast<std::size_t>(camera)].pending;
      if (pending.empty()) continue;
      const std::int64_t after_us = event.t_us - pending.front().t_us;
      const bool is_own = event.camera == camera;
      if (after_us > longest_us || (is_own && (after_us < 0 || pending.size() == most_events))) flush(camera);
    }
    sides_[event.camera].pending.push_back(event);
  }
}

void MessageWriter::sync() {
  for (int camera = 0; camera < cameras_; ++camera) flush(camera);
  put_chunk();
  file_.sync();
}

void MessageWriter::commit() {
  for (int camera = 0; camera < cameras_; ++camera) flush(camera);
  finish();
  file_.commit();
}

std::string MessageWriter::topic(std::string_view device, int camera) const {
  const std::string side = cameras_ == 1 ? "" : camera == 0 ? "/left" : "/right";
  return "/" + std::string(device) + side + "/events";
}

void MessageWriter::flush(int camera) {
  auto& [pending, seq] = sides_[static_cast<std::size_t>(camera)];
  if (pending.empty()) return;
  const std::int64_t last_us = std::ranges::max_element(pending, {}, &Event::t_us)->t_us;
  put_message(camera, pending, seq++, static_cast<std::uint64_t>(last_us) * 1000);
  pending.clear();
}

void check_packet_size(const std::filesystem::path& path, ImageSize image_size) {
  constexpr int most_rows = 1 << 15;
  if (image_size.height <= most_rows) return;
  throw InputError(path.string(), "an image of " + text_of(image_size),
                   "at most " + std::to_string(most_rows) + " rows for EventPacket");
}

}  // namespace saccade
