#include "recording/aedat3_codec.h"

#include <algorithm>
#include <array>
#include <map>

#include "recording/aedat_chip.h"
#include "recording/block_reader.h"
#include "recording/byte_order.h"
#include "recording/codec.h"
#include "recording/input_file.h"
#include "recording/number_text.h"

namespace saccade {
namespace {

constexpr std::string_view line_end = "\r\n";
constexpr std::size_t longest_aedat3_line = 4096;
constexpr std::size_t packet_header_bytes = 28;
constexpr std::size_t aedat3_event_bytes = 8;
constexpr std::int16_t polarity_type = 1;
constexpr std::array<std::string_view, 6> type_names{"special",         "polarity",        "image",
                                                     "6-axis inertial", "9-axis inertial", "sample"};

std::string name_of(std::int16_t type) {
  const auto number = static_cast<std::size_t>(type);
  return number < type_names.size() ? std::string(type_names[number]) : "type " + std::to_string(type);
}

class Aedat3Reader final : public BlockReader {
 public:
  Aedat3Reader(InputFile file, const EventReadOptions& options)
      : BlockReader(std::move(file)), image_size_(options.image_size) {
    while (header_line()) {
    }
  }

  std::optional<ImageSize> image_size() const override {
    const auto known = sizes_.find(source_          ? *source_
                                   : sizes_.empty() ? std::int16_t{0}
                                                    : sizes_.begin()->first);
    return known != sizes_.end() ? known->second : image_size_;
  }
  std::string format() const override { return "AEDAT 3.1"; }
  std::string skipped() const override {
    std::string text;
    for (const auto& [what, count] : others_) append_count(text, count, what);
    return text;
  }

 protected:
  bool decode(std::span<Event> block, std::size_t& count) override {
    if (events_left_ == 0) return next_packet();
    const std::string_view ahead = file_.peek(aedat3_event_bytes);
    const std::size_t events = std::min({ahead.size() / aedat3_event_bytes, block.size(), events_left_});
    if (events == 0) file_.fail("the end of the file", "the rest of a packet");
    std::size_t invalid = 0;
    for (std::size_t i = 0; i < events; ++i) {
      const char* bytes = ahead.data() + i * aedat3_event_bytes;
      const auto data = load_little<std::uint32_t>(bytes);
      const auto stamp = load_little<std::int32_t>(bytes + 4);
      if (stamp < 0) {
        file_.skip(i * aedat3_event_bytes + 4);
        file_.fail("the time " + std::to_string(stamp), "one of 0 us or more");
      }
      block[count] = {packet_time_us_ | stamp, static_cast<std::uint16_t>(data >> 17),
                      static_cast<std::uint16_t>(data >> 2 & 0x7fff), (data & 2) != 0, 0};
      count += data & 1;
      invalid += 1 - (data & 1);
    }
    if (invalid > 0) others_["invalid events"] += static_cast<std::int64_t>(invalid);
    file_.skip(events * aedat3_event_bytes);
    events_left_ -= events;
    return true;
  }

 private:
  /// Takes a line of the header; false for its last one.
  bool header_line() {
    const std::string_view ahead = file_.peek(longest_aedat3_line).substr(0, longest_aedat3_line);
    const std::string_view line = ahead.substr(0, ahead.find(line_end));
    if (line.size() == ahead.size()) {
      if (ahead.size() < longest_aedat3_line) file_.fail("the end of the file", "the rest of the header");
      file_.fail("a line of more than " + std::to_string(longest_aedat3_line) + " bytes", "header lines");
    }
    if (!line.starts_with('#')) file_.fail(printable(line.substr(0, 20)), "a header line, or #!END-HEADER");
    constexpr std::string_view format_key = "#Format: ";
    if (line.starts_with(format_key) && line.substr(format_key.size()) != "RAW") {
      file_.fail("the format " + printable(line.substr(format_key.size())), "RAW");
    }
    note_source(line);
    const bool last = line == "#!END-HEADER";
    file_.skip(line.size() + line_end.size());
    return !last;
  }

  /// `#Source 1: DAVIS346`
  void note_source(std::string_view line) {
    constexpr std::string_view key = "#Source ";
    const std::size_t colon = line.find(": ");
    std::int16_t number = 0;
    if (!line.starts_with(key) || colon == std::string_view::npos || colon < key.size()) return;
    if (!parse_number(line.substr(key.size(), colon - key.size()), number)) return;
    if (const auto size = parse_aedat_chip(line.substr(colon + 2)).size) sizes_[number] = *size;
  }

  /// Takes the header of the next packet, and the packet too where it is not one of our events; false at the end.
  bool next_packet() {
    const std::string_view head = file_.peek(packet_header_bytes);
    if (head.empty()) return false;
    if (head.size() < packet_header_bytes) file_.fail("the end of the file", "a packet's header of 28 bytes");
    const auto type = load_little<std::int16_t>(head.data());
    const auto source = load_little<std::int16_t>(head.data() + 2);
    const auto size = load_little<std::int32_t>(head.data() + 4);
    const auto time_place = load_little<std::int32_t>(head.data() + 8);
    const auto overflow = load_little<std::int32_t>(head.data() + 12);
    const auto events = load_little<std::int32_t>(head.data() + 20);
    if (type < 0 || size < 0 || overflow < 0 || events < 0) {
      file_.fail("a packet of type " + std::to_string(type) + ", of " + std::to_string(events) +
                     " events of " + std::to_string(size) + " bytes, after " + std::to_string(overflow) +
                     " wraps",
                 "numbers of 0 or more");
    }
    if (type == polarity_type && (size != aedat3_event_bytes || time_place != 4)) {
      file_.fail("polarity events of " + std::to_string(size) + " bytes with the time at byte " +
                     std::to_string(time_place),
                 "8 bytes with the time at byte 4");
    }
    file_.skip(packet_header_bytes);
    if (type == polarity_type && !source_) source_ = source;
    if (type == polarity_type && source == *source_) {
      packet_time_us_ = static_cast<std::int64_t>(overflow) << 31;
      events_left_ = static_cast<std::size_t>(events);
    } else {
      others_[type == polarity_type ? "events of source " + std::to_string(source)
                                    : name_of(type) + " events"] += events;
      const auto bytes = static_cast<std::uint64_t>(events) * static_cast<std::uint64_t>(size);
      if (!file_.discard(bytes)) file_.fail("the end of the file", "the rest of a packet");
    }
    return true;
  }

  std::optional<ImageSize> image_size_;
  std::map<std::int16_t, ImageSize> sizes_;  ///< by source
  std::optional<std::int16_t> source_;
  std::int64_t packet_time_us_ = 0;
  std::size_t events_left_ = 0;
  std::map<std::string, std::int64_t> others_;
};

}  // namespace

RecordingFormat aedat3_format() {
  RecordingFormat format;
  format.name = "AEDAT 3.1";
  format.extensions = {".aedat"};
  format.sniff = [](const FileStart& start) { return start.begins_with("#!AER-DAT3.1"); };
  format.open = [](InputFile file, const EventReadOptions& options) -> std::unique_ptr<EventReader> {
    return std::make_unique<Aedat3Reader>(std::move(file), options);
  };
  format.reads = "polarity events of one source, format RAW";
  format.time = "i32 us and a count of wraps at 2^31";
  format.axes = "top left, 1 is ON";
  return format;
}

}  // namespace saccade
