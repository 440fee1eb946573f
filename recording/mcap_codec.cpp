#include "recording/mcap_codec.h"

#include "recording/byte_order.h"
#include "recording/codec.h"
#include "recording/message_reader.h"

namespace saccade {
namespace {

constexpr std::size_t message_head_bytes = 2 + 4 + 8 + 8;
constexpr std::size_t chunk_head_bytes = 8 + 8 + 8 + 4;

/// The members of a record. Once one is missing, all further ones are 0 or empty, and `ok` is false.
class McapFields {
 public:
  explicit McapFields(std::string_view bytes) : bytes_(bytes) {}

  template <std::integral T>
  [[nodiscard]] T number() {
    const std::string_view bytes = take(sizeof(T));
    return ok ? load_little<T>(bytes.data()) : T{0};
  }
  [[nodiscard]] std::string text() { return std::string(take(number<std::uint32_t>())); }

  bool ok = true;

 private:
  [[nodiscard]] std::string_view take(std::size_t count) {
    if (!ok || bytes_.size() < count) {
      ok = false;
      return {};
    }
    const std::string_view taken = bytes_.substr(0, count);
    bytes_.remove_prefix(count);
    return taken;
  }

  std::string_view bytes_;
};

class McapReader final : public MessageReader {
 public:
  McapReader(InputFile file, const EventReadOptions& options)
      : MessageReader(std::move(file), "MCAP", options) {
    if (file_.peek(mcap_mark.size()).substr(0, mcap_mark.size()) != mcap_mark)
      file_.fail("another mark", "the mark of MCAP's version 0");
    file_.skip(mcap_mark.size());
    read_ahead();
  }

 protected:
  bool next() override {
    while (true) {
      if (in_chunk_) {
        if (!part_.over()) {
          if (read_record(part_)) return true;
          continue;
        }
        in_chunk_ = false;
        if (chunk_crc_ != 0 && part_.crc() != chunk_crc_)
          file_.fail("a chunk with another checksum", "a sound chunk");
      }
      if (read_footer_) {
        if (file_.peek(mcap_mark.size()) != mcap_mark)
          file_.fail("another end of the file than MCAP's mark",
                     "the mark after the footer, and nothing more");
        return false;
      }
      begin_record();
      if (file_.peek(1).empty()) file_.fail("the end of the file", "a footer; the recording was cut off");
      if (read_record(file_)) return true;
    }
  }

 private:
  /// True where the record was a message of events.
  template <class Source>
  bool read_record(Source& source) {
    const std::string_view head = source.peek(9);
    if (head.size() < 9) fail_cut();
    const auto op = static_cast<McapOp>(head[0]);
    const auto bytes = load_little<std::uint64_t>(head.data() + 1);
    source.skip(9);
    switch (op) {
      case McapOp::message:
        return read_message(source, bytes);
      case McapOp::schema:
        read_small(source, bytes);
        read_schema();
        break;
      case McapOp::channel:
        read_small(source, bytes);
        read_channel();
        break;
      case McapOp::chunk:
        if (in_chunk_) file_.fail("a chunk in a chunk", "messages");
        begin_chunk(bytes);
        break;
      case McapOp::footer:
        if (in_chunk_) file_.fail("a footer in a chunk", "messages");
        read_footer_ = true;
        [[fallthrough]];
      default:
        if (op == McapOp{}) file_.fail("a record of opcode 0", "a record");
        if (!source.discard(bytes)) fail_cut();
    }
    return false;
  }

  /// A record that is read as a whole.
  template <class Source>
  void read_small(Source& source, std::uint64_t bytes) {
    if (bytes > most_header_bytes)
      file_.fail("a record of " + std::to_string(bytes) + " bytes", "at most 2^20");
    if (!read_bytes(source, bytes, data_)) fail_cut();
  }

  void read_schema() {
    McapFields fields(data_);
    const auto id = fields.number<std::uint16_t>();
    const std::string name = fields.text();
    if (!fields.ok) file_.fail("a schema that ends early", "a whole schema");
    schemas_[id] = name;
  }

  void read_channel() {
    McapFields fields(data_);
    const auto id = fields.number<std::uint16_t>();
    const auto schema = fields.number<std::uint16_t>();
    const std::string topic = fields.text();
    const std::string encoding = fields.text();
    if (!fields.ok) file_.fail("a channel that ends early", "a whole channel");
    const bool is_cdr = encoding == "cdr";
    const bool is_read = is_cdr || encoding == "ros1";
    const std::string type = schemas_.contains(schema) ? schemas_.at(schema) : "";
    add_topic(id, topic, is_read ? type : type + " in " + encoding,
              is_cdr ? Serialisation::cdr : Serialisation::ros1);
  }

  template <class Source>
  bool read_message(Source& source, std::uint64_t bytes) {
    const std::string_view head = source.peek(message_head_bytes);
    if (head.size() < message_head_bytes || bytes < message_head_bytes) fail_cut();
    const auto id = load_little<std::uint16_t>(head.data());
    const auto log_time_ns = load_little<std::uint64_t>(head.data() + 6);
    source.skip(message_head_bytes);
    bytes -= message_head_bytes;
    if (!wants(id)) {
      if (!source.discard(bytes)) fail_cut();
      return false;
    }
    if (bytes > most_message_bytes)
      file_.fail("a message of " + std::to_string(bytes) + " bytes", "at most 2^26");
    const bool whole = read_bytes(source, bytes, data_);
    take(id, data_, log_time_ns);
    if (!whole) fail_cut();
    return true;
  }

  void begin_chunk(std::uint64_t bytes) {
    const std::string_view head = file_.peek(chunk_head_bytes + 4);
    if (head.size() < chunk_head_bytes + 4) fail_cut();
    chunk_crc_ = load_little<std::uint32_t>(head.data() + 24);
    const auto word_bytes = load_little<std::uint32_t>(head.data() + chunk_head_bytes);
    if (word_bytes > 16) file_.fail("a chunk of an unknown compression", "none, lz4 or zstd");
    const std::size_t before = chunk_head_bytes + 4 + word_bytes + 8;
    const std::string_view whole_head = file_.peek(before);
    if (whole_head.size() < before) fail_cut();
    const std::string word(whole_head.substr(chunk_head_bytes + 4, word_bytes));
    const auto stored = load_little<std::uint64_t>(whole_head.data() + before - 8);
    file_.skip(before);
    if (bytes < before || bytes - before != stored)
      file_.fail("a chunk of " + std::to_string(stored) + " bytes in a record of " + std::to_string(bytes),
                 "a record that its chunk fills");
    part_.begin(decompressor(word), stored);
    in_chunk_ = true;
  }

  [[noreturn]] void fail_cut() const {
    file_.fail(in_chunk_ ? "a record that ends after its chunk" : "the end of the file inside a record",
               "whole records");
  }

  bool in_chunk_ = false;
  bool read_footer_ = false;
  std::uint32_t chunk_crc_ = 0;  ///< of the newest chunk; 0: unknown
  std::map<std::uint16_t, std::string> schemas_;
  std::string data_;
};

}  // namespace

RecordingFormat mcap_format() {
  RecordingFormat format;
  format.name = "MCAP";
  format.extensions = {".mcap"};
  format.folder_mark = "metadata.yaml";
  format.sniff = [](const FileStart& start) { return start.begins_with(mcap_mark); };
  format.open = [](InputFile file, const EventReadOptions& options) -> std::unique_ptr<EventReader> {
    return std::make_unique<McapReader>(std::move(file), options);
  };
  format.create = create_mcap;
  format.cameras = 2;
  format.reads =
      "ROS 1 and ROS 2 (CDR) messages of the types read from bags; uncompressed, LZ4, ZSTD; checksums of "
      "chunks";
  format.writes =
      "`event_camera_msgs/msg/EventPacket` (mono) on `/event_camera/events`, of two cameras on "
      "`/event_camera/left/events` and `/event_camera/right/events`, ZSTD, with indices";
  format.time = "ns, to the nearest us; evt2 34, evt3 24 bits of us";
  format.axes = "top left, 1 is ON";
  format.limits = "y below 32768, times from 0 to 2^31 s";
  return format;
}

}  // namespace saccade
