#include "recording/aedat4_codec.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <map>
#include <stdexcept>

#include "core/error.h"
#include "recording/codec.h"
#include "recording/decompressor.h"
#include "recording/input_file.h"
#include "recording/number_text.h"

namespace saccade {
namespace {

static_assert(std::endian::native == std::endian::little);

constexpr std::string_view mark_line = "#!AER-DAT4.0\r\n";
constexpr std::size_t longest_header = 1 << 19;
constexpr std::size_t window_bytes = 1 << 16;
constexpr std::size_t event_bytes = 16;
constexpr int largest_length_px = 1 << 15;

/// A number at a place of some bytes; throws std::out_of_range where they end before it does.
template <class T>
T load(std::string_view bytes, std::size_t place) {
  if (place > bytes.size() || bytes.size() - place < sizeof(T)) throw std::out_of_range("load");
  T value;
  std::memcpy(&value, bytes.data() + place, sizeof value);
  return value;
}

/// The root table of a FlatBuffers buffer. Whatever the bytes are, nothing outside them is read: an offset
/// that leads there is a std::out_of_range.
class FlatTable {
 public:
  explicit FlatTable(std::string_view buffer)
      : buffer_(buffer),
        table_(load<std::uint32_t>(buffer, 0)),
        field_places_(table_ - static_cast<std::size_t>(load<std::int32_t>(buffer, table_))) {}

  [[nodiscard]] std::string_view identifier() const { return buffer_.substr(4, 4); }

  template <class T>
  [[nodiscard]] T number(std::size_t field, T absent) const {
    const std::size_t place = place_of(field);
    return place == 0 ? absent : load<T>(buffer_, place);
  }

  /// Number of elements and place of the first one of a vector or string; none of them where it is absent.
  struct Vector {
    std::size_t count = 0;
    std::size_t place = 0;
  };
  [[nodiscard]] Vector vector(std::size_t field) const {
    const std::size_t place = place_of(field);
    if (place == 0) return {};
    const std::size_t target = place + load<std::uint32_t>(buffer_, place);
    return {load<std::uint32_t>(buffer_, target), target + sizeof(std::uint32_t)};
  }
  [[nodiscard]] std::string_view text(std::size_t field) const {
    const Vector characters = vector(field);
    return buffer_.substr(characters.place, characters.count);
  }

 private:
  /// Where a field is in the buffer, 0 where it is absent.
  [[nodiscard]] std::size_t place_of(std::size_t field) const {
    const std::size_t entry = 4 + 2 * field;
    if (entry + 2 > load<std::uint16_t>(buffer_, field_places_)) return 0;
    const std::size_t place = load<std::uint16_t>(buffer_, field_places_ + entry);
    return place == 0 ? 0 : table_ + place;
  }

  std::string_view buffer_;
  std::size_t table_;
  std::size_t field_places_;
};

struct Stream {
  std::string type;
  ImageSize size;
};

/// The value of `name="value"` in a tag.
std::string_view attribute(std::string_view tag, std::string_view name) {
  const std::string key = " " + std::string(name) + "=\"";
  const std::size_t begin = tag.find(key);
  if (begin == std::string_view::npos) return {};
  const std::string_view rest = tag.substr(begin + key.size());
  return rest.substr(0, rest.find('"'));
}

/// The streams by their number: nodes outInfo/N of the XML with the attribute typeIdentifier, and sizeX and
/// sizeY in their node info.
std::map<std::int32_t, Stream> parse_streams(std::string_view xml) {
  std::map<std::int32_t, Stream> streams;
  std::vector<std::string_view> nodes;
  for (std::size_t open = xml.find('<'); open != std::string_view::npos; open = xml.find('<', open + 1)) {
    const std::size_t close = std::min(xml.find('>', open), xml.size() - 1);
    const std::string_view tag = xml.substr(open + 1, close - open - 1);
    if (tag.starts_with("node ") && !tag.ends_with('/')) nodes.push_back(attribute(tag, "name"));
    if (tag.starts_with("/node") && !nodes.empty()) nodes.pop_back();
    const auto root = std::find(nodes.begin(), nodes.end(), "outInfo");
    std::int32_t number = 0;
    if (!tag.starts_with("attr ") || nodes.end() - root < 2 || !parse_number(root[1], number)) continue;
    const std::string_view value = xml.substr(close + 1, xml.find('<', close) - close - 1);
    const std::string_view key = attribute(tag, "key");
    Stream& stream = streams[number];
    if (key == "typeIdentifier") stream.type = value;
    if (key == "sizeX") (void)parse_number(value, stream.size.width);
    if (key == "sizeY") (void)parse_number(value, stream.size.height);
  }
  return streams;
}

class Aedat4Reader final : public EventReader {
 public:
  Aedat4Reader(InputFile file, const EventReadOptions& options)
      : file_(std::move(file)), image_size_(options.image_size), window_(window_bytes) {
    try {
      read_header();
    } catch (const std::out_of_range&) {
      fail("an offset that leads outside the header", "a whole header");
    }
  }

  std::size_t read(std::vector<Event>& events, std::size_t max_events) override {
    std::size_t count = 0;
    try {
      while (count < max_events && find_events()) count += decode(events, max_events - count);
    } catch (const InputError& error) {
      failure_ = error;
    }
    if (count == 0 && failure_) throw InputError(*failure_);
    return count;
  }

  std::optional<ImageSize> image_size() const override { return image_size_; }
  std::string format() const override { return "AEDAT 4.0" + compression_; }
  std::string passed_over() const override {
    std::string text;
    for (const auto& [number, packets] : other_packets_) {
      const auto known = streams_.find(number);
      append_count(text, packets,
                   "packets of stream " + std::to_string(number) +
                       (known == streams_.end() ? "" : " (" + printable(known->second.type) + ")"));
    }
    return text;
  }

 private:
  void read_header() {
    const std::string_view start = file_.peek(mark_line.size() + 4);
    if (!start.starts_with(mark_line)) fail(printable(start.substr(0, 14)), "the line #!AER-DAT4.0");
    if (start.size() < mark_line.size() + 4) fail_cut("the header's size");
    const auto size = load<std::uint32_t>(start, mark_line.size());
    file_.skip(mark_line.size() + 4);
    if (size > longest_header) {
      fail("a header of " + std::to_string(size) + " bytes", "at most " + std::to_string(longest_header));
    }
    const std::string_view bytes = file_.peek(size).substr(0, size);
    if (bytes.size() < size) fail_cut("the rest of the header");
    const FlatTable header(bytes);
    if (header.identifier() != "IOHE") fail(printable(header.identifier()), "a header table IOHE");
    choose_decompressor(header.number<std::int32_t>(0, 0));
    const auto end = header.number<std::int64_t>(1, -1);
    if (end >= 0) packets_end_ = static_cast<std::uint64_t>(end);
    streams_ = parse_streams(header.text(2));
    choose_stream();
    file_.skip(size);
    if (packets_end_ < file_.offset()) {
      fail("a table of packets at byte " + std::to_string(packets_end_), "one behind the header");
    }
  }

  void choose_decompressor(std::int32_t compression) {
    if (compression == 0) {
      decompressor_ = make_copier();
    } else if (compression == 1 || compression == 2) {
      decompressor_ = make_lz4_decompressor();
      compression_ = " LZ4";
    } else if (compression == 3 || compression == 4) {
      decompressor_ = make_zstd_decompressor();
      compression_ = " ZSTD";
    } else {
      fail("the compression " + std::to_string(compression), "0 none, 1 or 2 LZ4, 3 or 4 ZSTD");
    }
  }

  void choose_stream() {
    const auto is_events = [](const auto& entry) { return entry.second.type == "EVTS"; };
    const auto found = std::find_if(streams_.begin(), streams_.end(), is_events);
    if (found == streams_.end()) fail("no stream of events", "a stream of type EVTS in the header");
    stream_ = found->first;
    const ImageSize size = found->second.size;
    const auto is_length = [](int length_px) { return length_px > 0 && length_px <= largest_length_px; };
    if (is_length(size.width) && is_length(size.height)) image_size_ = size;
  }

  /// Makes sure that there is an event in the window; false at the end of the packets.
  bool find_events() {
    while (events_left_ == 0 || window_end_ - window_begin_ < event_bytes) {
      if (failure_) throw InputError(*failure_);
      if (events_left_ == 0) {
        if (!next_packet()) return false;
      } else if (packet_is_over()) {
        fail("a packet that ends " + std::to_string(events_left_) + " events early", "all of its events");
      } else {
        fill_window();
      }
    }
    return true;
  }

  std::size_t decode(std::vector<Event>& events, std::size_t max_events) {
    const std::size_t count =
        std::min({max_events, events_left_, (window_end_ - window_begin_) / event_bytes});
    const std::size_t first = events.size();
    events.resize(first + count);
    const char* bytes = window_.data() + window_begin_;
    for (std::size_t i = 0; i < count; ++i, bytes += event_bytes) {
      Event& event = events[first + i];
      std::memcpy(&event.t_us, bytes, sizeof event.t_us);
      std::memcpy(&event.x, bytes + 8, sizeof event.x);
      std::memcpy(&event.y, bytes + 10, sizeof event.y);
      event.on = bytes[12] != 0;
    }
    window_begin_ += count * event_bytes;
    events_left_ -= count;
    return count;
  }

  /// Goes behind the packet at hand and opens the next one; false at the end of the packets.
  bool next_packet() {
    while (!packet_is_over()) {
      window_begin_ = window_end_;
      fill_window();
      if (failure_) throw InputError(*failure_);
    }
    if (file_.offset() == packets_end_) return false;
    const std::string_view head = file_.peek(8);
    if (head.empty() && packets_end_ == no_end) return false;
    if (head.size() < 8) fail_cut("a packet");
    const auto stream = load<std::int32_t>(head, 0);
    const auto size = load<std::int32_t>(head, 4);
    if (size < 0 || packets_end_ - file_.offset() < 8 + static_cast<std::uint64_t>(size)) {
      fail("a packet of " + std::to_string(size) + " bytes", "one that ends before the table of packets");
    }
    file_.skip(8);
    if (stream != stream_) {
      if (!file_.pass_over(static_cast<std::uint64_t>(size))) fail_cut("the rest of a packet");
      ++other_packets_[stream];
    } else {
      packet_left_ = static_cast<std::size_t>(size);
      open_packet();
    }
    return true;
  }

  void open_packet() {
    decompressor_->begin();
    window_begin_ = window_end_ = 0;
    fill_window();
    const std::string_view start(window_.data(), window_end_);
    try {
      const FlatTable packet(start.substr(std::min<std::size_t>(4, start.size())));
      if (packet.identifier() != "EVTS") fail("a packet " + printable(packet.identifier()), "one of EVTS");
      const FlatTable::Vector elements = packet.vector(0);
      const std::size_t bytes = load<std::uint32_t>(start, 0);
      if (elements.place + elements.count * event_bytes > bytes) {
        fail(std::to_string(elements.count) + " events in a packet of " + std::to_string(bytes) + " bytes",
             "a packet that holds its events");
      }
      events_left_ = elements.count;
      window_begin_ = std::min(4 + elements.place, window_end_);
    } catch (const std::out_of_range&) {
      if (failure_) throw InputError(*failure_);
      fail("an offset that leads outside the packet", "a whole packet");
    }
  }

  [[nodiscard]] bool packet_is_over() const { return packet_left_ == 0 && !decompressor_->unfinished(); }

  /// Unpacks until the window is full or the packet is over. What goes wrong is kept in failure_, to be
  /// told when the events before it have been read.
  void fill_window() {
    std::copy(window_.begin() + static_cast<std::ptrdiff_t>(window_begin_),
              window_.begin() + static_cast<std::ptrdiff_t>(window_end_), window_.begin());
    window_end_ -= window_begin_;
    window_begin_ = 0;
    try {
      while (window_end_ < window_.size() && !packet_is_over()) unpack();
    } catch (const InputError& error) {
      failure_ = error;
    }
  }

  void unpack() {
    const std::string_view ahead = packet_left_ > 0 ? file_.peek(1).substr(0, packet_left_) : "";
    const Decompressor::Step step = decompressor_->run(ahead, std::span(window_).subspan(window_end_));
    if (step.error != nullptr) fail(step.error, "a packet that can be unpacked");
    file_.skip(step.read);
    packet_left_ -= step.read;
    window_end_ += step.written;
    if (step.read > 0 || step.written > 0) return;
    if (packet_left_ > 0) fail_cut("the rest of a packet");
    fail("a packet without its end", "a packet that can be unpacked");
  }

  [[noreturn]] void fail(std::string value, std::string expectation) const {
    file_.fail(std::move(value), std::move(expectation));
  }
  [[noreturn]] void fail_cut(std::string expectation) const {
    fail("the end of the file", std::move(expectation));
  }

  static constexpr std::uint64_t no_end = std::numeric_limits<std::uint64_t>::max();

  InputFile file_;
  std::optional<ImageSize> image_size_;
  std::string compression_;
  std::unique_ptr<Decompressor> decompressor_;
  std::map<std::int32_t, Stream> streams_;
  std::map<std::int32_t, std::int64_t> other_packets_;  ///< of streams that are passed over
  std::int32_t stream_ = 0;
  std::uint64_t packets_end_ = no_end;
  std::size_t packet_left_ = 0;  ///< bytes of the packet still in the file
  std::size_t events_left_ = 0;  ///< in the packet
  std::vector<char> window_;     ///< unpacked bytes, those in [window_begin_, window_end_) not yet read
  std::size_t window_begin_ = 0;
  std::size_t window_end_ = 0;
  std::optional<InputError> failure_;
};

}  // namespace

RecordingFormat aedat4_format() {
  RecordingFormat format;
  format.name = "AEDAT 4.0";
  format.extensions = {".aedat4"};
  format.sniff = [](const FileStart& start) { return start.begins_with("#!AER-DAT4.0"); };
  format.open = [](InputFile file, const EventReadOptions& options) -> std::unique_ptr<EventReader> {
    return std::make_unique<Aedat4Reader>(std::move(file), options);
  };
  format.create = create_aedat4;
  format.reads = "one stream of events; uncompressed, LZ4, ZSTD";
  format.writes = "LZ4, with the table of packets";
  format.time = "i64 us";
  format.axes = "top left, 1 is ON";
  format.limits = "32767 x 32767, one camera";
  return format;
}

}  // namespace saccade
