#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "recording/address_event.h"
#include "recording/codec.h"
#include "recording/number_text.h"
#include "recording/output_file.h"
#include "recording/yarp_codec.h"
#include "recording/yarp_log_codec.h"
#include "recording/yarp_log_info.h"
#include "recording/yarp_log_packets.h"

namespace saccade {
namespace {

void append_escaped(std::string& text, std::uint32_t word) {
  for (int shift = 0; shift < 32; shift += 8) {
    const char c = static_cast<char>(word >> shift & 0xff);
    if (c == '\0') {
      text += "\\0";
    } else if (c == '\n') {
      text += "\\n";
    } else if (c == '\r') {
      text += "\\r";
    } else {
      if (c == '"' || c == '\\') text += '\\';
      text += c;
    }
  }
}

class YarpLogWriter final : public EventWriter {
 public:
  YarpLogWriter(const std::filesystem::path& path, ImageSize size, int cameras)
      : file_(path), info_(yarp_info_file(path)), size_(size), cameras_(cameras) {}

  void write(std::span<const Event> events) override {
    for (const Event& event : events) {
      check_writable(event, size_, cameras_, file_.path());
      if (event.t_us < 0 || static_cast<double>(event.t_us) >= yarp_latest_s * 1e6) {
        throw InputError(file_.path().string(), "an event at " + std::to_string(event.t_us) + " us",
                         "times from 0 to 4e15 us; " + std::string(zero_time_hint));
      }
      if (!origin_us_) origin_us_ = event.t_us < counter_us ? 0 : event.t_us;
      if (!packet_.empty() &&
          (packet_.size() == packet_events || std::abs(event.t_us - packet_.front().t_us) >= packet_us)) {
        write_packet();
      }
      packet_.push_back(event);
    }
  }

  void sync() override {
    write_packet();
    file_.sync();
  }

  void commit() override {
    write_packet();
    // The data player needs the first two lines; the others are read by this library.
    std::string info = "Type: Bottle;\n[0.000000] /saccade/AE:o [connected]\n";
    const auto add = [&](std::string_view key, const auto& value) {
      info.append(key).append(value).append(";\n");
    };
    add(yarp_codec_key, codec_.name);
    add(yarp_size_key, text_of(size_));
    add(yarp_bits_key, std::to_string(stamp_bits));
    add(yarp_origin_key, std::to_string(origin_us_.value_or(0)));
    info_.write(info);
    info_.commit();
    file_.commit();
  }

 private:
  static constexpr std::size_t packet_events = 4096;
  static constexpr std::int64_t packet_us = 1000;
  static constexpr int stamp_bits = 31;
  /// How long the counter runs until it wraps.
  static constexpr std::int64_t counter_us = (std::int64_t{1} << stamp_bits) / 25 * 2;

  void write_packet() {
    if (packet_.empty()) return;
    const std::int64_t host_us = packet_.back().t_us;
    line_.clear();
    append_number(line_, packets_++);
    line_ += ' ';
    append_seconds(line_, host_us);
    line_ += " AE ";
    append_number(line_, std::max<std::int64_t>(host_us - packet_.front().t_us, 1));
    line_ += " \"";
    for (const Event& event : packet_) {
      const std::int64_t ticks = ticks_from_us(event.t_us - *origin_us_, tick_ns(codec_.address));
      const auto stamp = static_cast<std::uint32_t>(ticks & ((std::int64_t{1} << stamp_bits) - 1));
      append_escaped(line_, stamp);
      append_escaped(line_, encode_address(event, codec_.address));
    }
    line_ += "\"\n";
    file_.write(line_);
    packet_.clear();
  }

  OutputFile file_;
  OutputFile info_;
  ImageSize size_;
  int cameras_;
  const YarpCodec& codec_ = yarp_codec("ev2_ts", "codec");
  std::optional<std::int64_t> origin_us_;  ///< when the counter was 0
  std::vector<Event> packet_;
  std::int64_t packets_ = 0;
  std::string line_;
};

}  // namespace

std::unique_ptr<EventWriter> create_yarp_log(const std::filesystem::path& path, ImageSize image_size,
                                             int cameras) {
  if (!is_encodable(image_size, AddressCodec::ev2)) {
    throw InputError(path.string(), "an image of " + text_of(image_size),
                     "at most 2048x1024 for an event-driven log");
  }
  return std::make_unique<YarpLogWriter>(path, image_size, cameras);
}

}  // namespace saccade
