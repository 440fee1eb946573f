#include "recording/aedat4_codec.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <map>

#include "core/error.h"
#include "recording/aedat4_generated.h"
#include "recording/aedat4_others.h"
#include "recording/byte_order.h"
#include "recording/codec.h"
#include "recording/decompressor.h"
#include "recording/input_file.h"
#include "recording/number_text.h"
#include "recording/two_cameras.h"
#include "recording/unpacked_part.h"

namespace saccade {
namespace {

constexpr std::size_t longest_aedat4_header = 1 << 19;
constexpr std::size_t window_bytes = 1 << 16;
constexpr std::size_t aedat4_event_bytes = sizeof(aedat4::Event);
constexpr int largest_read_length_px = 1 << 15;
constexpr std::size_t most_packet_bytes = 1 << 28;  ///< of one that is read as a whole, decompressed

/// Of recorded tables: offsets are checked before they are followed, and values may lie at any address.
flatbuffers::Verifier verifier_of(std::string_view bytes) {
  flatbuffers::Verifier::Options options;
  options.check_alignment = false;
  return flatbuffers::Verifier(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size(), options);
}

/// The identifier of a table, fewer than 4 letters where the bytes end before.
std::string_view identifier_of(std::string_view table) {
  return table.substr(std::min<std::size_t>(4, table.size()), 4);
}

/// Number of elements in an EventPacket, and the offset of the first one in its bytes.
struct Elements {
  std::size_t count = 0;
  std::size_t offset = 0;
};

/// `start`: the first bytes of a packet's table, without its size. None where an offset leads outside of them. The
/// elements are decompressed later, piece by piece, so of the generated EventPacket::Verify all is done here but the last
/// step, the check of the vector's end.
std::optional<Elements> find_elements(std::string_view start) {
  flatbuffers::Verifier verifier = verifier_of(start);
  const flatbuffers::uoffset_t root =
      start.size() < 8 ? 0 : static_cast<flatbuffers::uoffset_t>(verifier.VerifyOffset(0));
  if (root == 0) return std::nullopt;
  const auto* table = reinterpret_cast<const flatbuffers::Table*>(start.data() + root);
  constexpr auto field = aedat4::EventPacket::VT_ELEMENTS;
  if (!table->VerifyTableStart(verifier) || !table->VerifyOffset(verifier, field)) return std::nullopt;
  const auto* elements = table->GetPointer<const flatbuffers::Vector<std::uint8_t>*>(field);
  if (elements == nullptr) return Elements{};
  const auto offset = static_cast<std::size_t>(reinterpret_cast<const char*>(elements) - start.data());
  if (!verifier.Verify<flatbuffers::uoffset_t>(offset)) return std::nullopt;
  return Elements{elements->size(), offset + sizeof(flatbuffers::uoffset_t)};
}

struct Stream {
  std::string type;
  std::string source;  ///< name of the camera
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
/// sizeY in their node info, with the camera's name as source.
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
    if (key == "source") stream.source = value;
    if (key == "sizeX") (void)parse_number(value, stream.size.width);
    if (key == "sizeY") (void)parse_number(value, stream.size.height);
  }
  return streams;
}

class Aedat4Reader final : public EventReader {
 public:
  /// `camera`: the first stream of events, or that of the second source of events.
  Aedat4Reader(InputFile file, const EventReadOptions& options, int camera = 0)
      : file_(std::move(file)),
        camera_(camera),
        others_(camera == 0 ? options.others : nullptr),
        image_size_(options.image_size),
        window_(window_bytes) {
    read_header();
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

  [[nodiscard]] std::optional<ImageSize> image_size() const override { return image_size_; }
  [[nodiscard]] std::string format() const override { return "AEDAT 4.0" + compression_; }
  [[nodiscard]] std::optional<std::uint64_t> broken_record() const override { return record_; }
  [[nodiscard]] bool has_second_camera() const { return second_stream_.has_value(); }
  [[nodiscard]] std::string skipped() const override {
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
    const std::string_view start = file_.peek(aedat4_mark.size() + 4);
    if (!start.starts_with(aedat4_mark)) fail(printable(start.substr(0, 14)), "the line #!AER-DAT4.0");
    if (start.size() < aedat4_mark.size() + 4) fail_cut("the header's size");
    const auto size = load_little<std::uint32_t>(start.data() + aedat4_mark.size());
    file_.skip(aedat4_mark.size() + 4);
    if (size > longest_aedat4_header) {
      fail("a header of " + std::to_string(size) + " bytes",
           "at most " + std::to_string(longest_aedat4_header));
    }
    const std::string_view bytes = file_.peek(size).substr(0, size);
    if (bytes.size() < size) fail_cut("the rest of the header");
    if (bytes.size() >= 8 && identifier_of(bytes) != aedat4::IOHeaderIdentifier()) {
      fail(printable(identifier_of(bytes)), "a header table IOHE");
    }
    flatbuffers::Verifier verifier = verifier_of(bytes);
    if (!aedat4::VerifyIOHeaderBuffer(verifier)) {
      fail("an offset that leads outside the header", "a whole header");
    }
    const aedat4::IOHeader* header = aedat4::GetIOHeader(bytes.data());
    choose_decompressor(header->compression());
    const std::int64_t end = header->data_table_position();
    if (end > 0) packets_end_ = static_cast<std::uint64_t>(end);
    if (header->info_node() != nullptr) streams_ = parse_streams(header->info_node()->string_view());
    choose_stream();
    file_.skip(size);
    if (packets_end_ < file_.offset()) {
      fail("a table of packets at byte " + std::to_string(packets_end_), "one after the header");
    }
  }

  void choose_decompressor(aedat4::Compression compression) {
    using enum aedat4::Compression;
    if (compression == none) {
      make_decompressor_ = make_copier;
    } else if (compression == lz4 || compression == lz4_high) {
      make_decompressor_ = make_lz4_decompressor;
      compression_ = " LZ4";
    } else if (compression == zstd || compression == zstd_high) {
      make_decompressor_ = make_zstd_decompressor;
      compression_ = " ZSTD";
    } else {
      fail("the compression " + std::to_string(static_cast<int>(compression)),
           "0 none, 1 or 2 LZ4, 3 or 4 ZSTD");
    }
    decompressor_ = make_decompressor_();
  }

  void choose_stream() {
    const auto is_events = [](const auto& entry) { return entry.second.type == "EVTS"; };
    auto found = std::find_if(streams_.begin(), streams_.end(), is_events);
    if (found == streams_.end()) fail("no stream of events", "a stream of type EVTS in the header");
    const auto of_another = [&](const auto& entry) {
      return is_events(entry) && !entry.second.source.empty() && entry.second.source != found->second.source;
    };
    const auto second = std::find_if(streams_.begin(), streams_.end(), of_another);
    if (second != streams_.end() && !found->second.source.empty()) second_stream_ = second->first;
    if (camera_ == 1 && second_stream_) found = second;
    stream_ = found->first;
    const ImageSize size = found->second.size;
    const auto is_length = [](int length_px) { return length_px > 0 && length_px <= largest_read_length_px; };
    if (is_length(size.width) && is_length(size.height)) image_size_ = size;
  }

  /// Makes sure that there is an event in the window; false at the end of the packets.
  bool find_events() {
    while (events_left_ == 0 || window_end_ - window_begin_ < aedat4_event_bytes) {
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
        std::min({max_events, events_left_, (window_end_ - window_begin_) / aedat4_event_bytes});
    const std::size_t first = events.size();
    events.resize(first + count);
    const char* bytes = window_.data() + window_begin_;
    for (std::size_t i = 0; i < count; ++i, bytes += aedat4_event_bytes) {
      aedat4::Event stored;
      std::memcpy(&stored, bytes, aedat4_event_bytes);
      Event& event = events[first + i];
      event.t_us = stored.timestamp();
      event.x = static_cast<std::uint16_t>(stored.x());
      event.y = static_cast<std::uint16_t>(stored.y());
      event.on = stored.on();
    }
    window_begin_ += count * aedat4_event_bytes;
    events_left_ -= count;
    return count;
  }

  /// Goes on after the current packet and opens the next one; false at the end of the packets.
  bool next_packet() {
    while (!packet_is_over()) {
      window_begin_ = window_end_;
      fill_window();
      if (failure_) throw InputError(*failure_);
    }
    record_ = file_.offset();
    if (record_ == packets_end_) return false;
    const std::string_view head = file_.peek(8);
    if (head.empty() && packets_end_ == no_end) return false;
    if (head.size() < 8) fail_cut("a packet");
    const auto stream = load_little<std::int32_t>(head.data());
    const auto size = load_little<std::int32_t>(head.data() + 4);
    if (size < 0 || packets_end_ - file_.offset() < 8 + static_cast<std::uint64_t>(size)) {
      fail("a packet of " + std::to_string(size) + " bytes", "one that ends before the table of packets");
    }
    file_.skip(8);
    if (const auto other = streams_.find(stream); stream != stream_ && other != streams_.end() &&
                                                  others_ != nullptr &&
                                                  wants_aedat4(*others_, other->second.type)) {
      read_other(other->second, static_cast<std::size_t>(size));
    } else if (stream != stream_) {
      if (!file_.discard(static_cast<std::uint64_t>(size))) fail_cut("the rest of a packet");
      if (camera_ == 0 && stream != second_stream_) ++other_packets_[stream];
    } else {
      packet_left_ = static_cast<std::size_t>(size);
      open_packet();
    }
    return true;
  }

  /// A packet of a stream that has no events.
  void read_other(const Stream& stream, std::size_t bytes) {
    UnpackedPart part(file_);
    part.begin(make_decompressor_(), bytes);
    std::string whole;
    for (std::string_view ahead = part.peek(1); !ahead.empty(); ahead = part.peek(1)) {
      if (whole.size() + ahead.size() > most_packet_bytes)
        fail("a packet of more than 2^28 bytes", "at most 2^28");
      whole.append(ahead);
      part.skip(ahead.size());
    }
    if (const auto broken = read_aedat4_others(stream.type, whole, stream.source, *others_))
      fail(broken->found, broken->expected);
  }

  void open_packet() {
    decompressor_->begin();
    window_begin_ = window_end_ = 0;
    fill_window();
    constexpr std::size_t prefix = sizeof(flatbuffers::uoffset_t);
    const std::string_view window(window_.data(), window_end_);
    const std::string_view start = window.substr(std::min(prefix, window.size()));
    if (start.size() >= 8 && identifier_of(start) != "EVTS") {
      fail("a packet " + printable(identifier_of(start)), "one of EVTS");
    }
    const std::optional<Elements> elements = find_elements(start);
    if (!elements) {
      if (failure_) throw InputError(*failure_);
      fail("an offset that leads outside the packet", "a whole packet");
    }
    const std::size_t bytes = load_little<std::uint32_t>(window.data());
    if (elements->offset + elements->count * aedat4_event_bytes > bytes) {
      fail(std::to_string(elements->count) + " events in a packet of " + std::to_string(bytes) + " bytes",
           "a packet that holds its events");
    }
    events_left_ = elements->count;
    window_begin_ = std::min(prefix + elements->offset, window_end_);
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
  int camera_;
  OtherRecords* others_;
  std::optional<ImageSize> image_size_;
  std::string compression_;
  std::unique_ptr<Decompressor> (*make_decompressor_)() = make_copier;
  std::unique_ptr<Decompressor> decompressor_;  ///< of packets of events
  std::map<std::int32_t, Stream> streams_;
  std::map<std::int32_t, std::int64_t> other_packets_;  ///< of streams that are skipped
  std::int32_t stream_ = 0;
  std::optional<std::int32_t> second_stream_;  ///< of the second camera
  std::uint64_t packets_end_ = no_end;
  std::uint64_t record_ = 0;     ///< where the packet begins, with its header
  std::size_t packet_left_ = 0;  ///< bytes of the packet still in the file
  std::size_t events_left_ = 0;  ///< in the packet
  std::vector<char> window_;     ///< unpacked bytes, those in [window_begin_, window_end_) not read yet
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
    const std::filesystem::path path = file.name();
    auto reader = std::make_unique<Aedat4Reader>(std::move(file), options);
    if (!reader->has_second_camera()) return reader;
    return merge_cameras(std::move(reader), std::make_unique<Aedat4Reader>(InputFile(path), options, 1));
  };
  format.cameras = 2;
  format.create = create_aedat4;
  format.reads =
      "the first stream of events, and where there is one the first from another source as the right camera, "
      "merged by time; uncompressed, LZ4, ZSTD";
  format.writes = "LZ4, with the table of packets; two cameras as two streams";
  format.time = "i64 us";
  format.axes = "top left, 1 is ON";
  format.limits = "32767 x 32767";
  return format;
}

}  // namespace saccade
