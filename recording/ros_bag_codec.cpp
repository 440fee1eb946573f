#include "recording/ros_bag_codec.h"

#include "recording/byte_order.h"
#include "recording/codec.h"
#include "recording/message_reader.h"

namespace saccade {
namespace {

constexpr std::string_view bag_mark = "#ROSBAG V2.0\n";

/// Values of a record's field `op`.
enum BagOp : std::uint8_t {
  message_data = 2,
  file_header = 3,
  index_data = 4,
  chunk = 5,
  chunk_info = 6,
  connection = 7,
};

/// The fields of a record: names and values.
class BagFields {
 public:
  /// False where the bytes are no fields. The values refer to `bytes`.
  [[nodiscard]] bool parse(std::string_view bytes) {
    fields_.clear();
    while (!bytes.empty()) {
      if (bytes.size() < 4) return false;
      const auto length = load_little<std::uint32_t>(bytes.data());
      bytes.remove_prefix(4);
      if (bytes.size() < length) return false;
      const std::string_view field = bytes.substr(0, length);
      const std::size_t equals = field.find('=');
      if (equals == std::string_view::npos) return false;
      fields_[std::string(field.substr(0, equals))] = field.substr(equals + 1);
      bytes.remove_prefix(length);
    }
    return true;
  }
  [[nodiscard]] std::string text(const std::string& name) const {
    const auto field = fields_.find(name);
    return field == fields_.end() ? "" : std::string(field->second);
  }
  template <std::integral T>
  [[nodiscard]] std::optional<T> number(const std::string& name) const {
    const auto field = fields_.find(name);
    if (field == fields_.end() || field->second.size() != sizeof(T)) return std::nullopt;
    return load_little<T>(field->second.data());
  }

 private:
  std::map<std::string, std::string_view> fields_;
};

class RosBagReader final : public MessageReader {
 public:
  RosBagReader(InputFile file, const EventReadOptions& options)
      : MessageReader(std::move(file), "ROS bag 2.0", options) {
    const std::string_view start = file_.peek(bag_mark.size()).substr(0, bag_mark.size());
    if (start != bag_mark) file_.fail(printable(start), "a bag of version 2.0, with the line #ROSBAG V2.0");
    file_.skip(bag_mark.size());
    read_ahead();
  }

 protected:
  bool next() override {
    while (true) {
      if (in_chunk_ && !part_.over()) {
        if (read_record(part_)) return true;
      } else {
        in_chunk_ = false;
        begin_record();
        if (file_.peek(1).empty()) {
          check_end();
          return false;
        }
        if (read_record(file_)) return true;
      }
    }
  }

 private:
  /// True where the record was a message of events.
  template <class Source>
  bool read_record(Source& source) {
    const auto header_bytes = read_length(source);
    if (header_bytes > most_header_bytes)
      file_.fail("a record with a header of " + std::to_string(header_bytes) + " bytes", "at most 2^20");
    if (!read_bytes(source, header_bytes, header_)) fail_cut();
    if (!fields_.parse(header_)) file_.fail("a record whose header has no fields", "fields name=value");
    const auto op = fields_.number<std::uint8_t>("op");
    const std::uint32_t data_bytes = read_length(source);
    if (op == message_data) return read_message(source, data_bytes);
    if (op == connection) {
      read_connection(source, data_bytes);
    } else if (op == chunk && !in_chunk_) {
      part_.begin(decompressor(fields_.text("compression")), data_bytes);
      in_chunk_ = true;
      ++chunks_;
    } else if (op == file_header && !in_chunk_) {
      indexed_ = fields_.number<std::uint64_t>("index_pos").value_or(0) != 0;
      chunk_count_ = fields_.number<std::uint32_t>("chunk_count").value_or(0);
      skip_data(source, data_bytes);
    } else if (op == index_data || op == chunk_info) {
      if (op == chunk_info) ++chunk_infos_;
      skip_data(source, data_bytes);
    } else {
      file_.fail("a record of op " + (op ? std::to_string(*op) : "none"), "a record of bags, op 2 to 7");
    }
    return false;
  }

  template <class Source>
  std::uint32_t read_length(Source& source) {
    const std::string_view ahead = source.peek(4);
    if (ahead.size() < 4) fail_cut();
    const auto length = load_little<std::uint32_t>(ahead.data());
    source.skip(4);
    return length;
  }

  template <class Source>
  bool read_message(Source& source, std::uint32_t bytes) {
    const auto id = fields_.number<std::uint32_t>("conn");
    if (!id) file_.fail("a message without a connection", "the field conn");
    const std::uint64_t time = fields_.number<std::uint64_t>("time").value_or(0);  // u32 s, u32 ns
    if (!wants(*id)) {
      skip_data(source, bytes);
      return false;
    }
    if (bytes > most_message_bytes)
      file_.fail("a message of " + std::to_string(bytes) + " bytes", "at most 2^26");
    const bool whole = read_bytes(source, bytes, data_);
    take(*id, data_, (time & 0xffffffff) * 1'000'000'000 + (time >> 32));
    if (!whole) fail_cut();
    return true;
  }

  template <class Source>
  void read_connection(Source& source, std::uint32_t bytes) {
    const auto id = fields_.number<std::uint32_t>("conn");
    const std::string topic = fields_.text("topic");
    if (!id) file_.fail("a connection without a number", "the field conn");
    if (bytes > most_header_bytes)
      file_.fail("a connection of " + std::to_string(bytes) + " bytes", "at most 2^20");
    if (!read_bytes(source, bytes, data_)) fail_cut();
    if (!fields_.parse(data_)) file_.fail("a connection without fields", "fields name=value");
    add_topic(*id, topic, fields_.text("type"), Serialisation::ros1);
  }

  template <class Source>
  void skip_data(Source& source, std::uint32_t bytes) {
    if (!source.discard(bytes)) fail_cut();
  }

  void check_end() const {
    if (!indexed_ || (chunks_ >= chunk_count_ && chunk_infos_ >= chunk_count_)) return;
    file_.fail("the end of the file after " + std::to_string(chunks_) + " chunks",
               std::to_string(chunk_count_) + " chunks and their index");
  }

  [[noreturn]] void fail_cut() const {
    file_.fail(in_chunk_ ? "a record that ends after its chunk" : "the end of the file inside a record",
               "whole records");
  }

  bool in_chunk_ = false;
  bool indexed_ = false;
  std::uint32_t chunk_count_ = 0;
  std::uint32_t chunks_ = 0;
  std::uint32_t chunk_infos_ = 0;
  BagFields fields_;  ///< of header_
  std::string header_;
  std::string data_;
};

}  // namespace

RecordingFormat ros_bag_format() {
  RecordingFormat format;
  format.name = "ROS bag";
  format.extensions = {".bag"};
  format.sniff = [](const FileStart& start) { return start.begins_with("#ROSBAG V"); };
  format.open = [](InputFile file, const EventReadOptions& options) -> std::unique_ptr<EventReader> {
    return std::make_unique<RosBagReader>(std::move(file), options);
  };
  format.create = create_ros_bag;
  format.cameras = 2;
  format.reads =
      "ROS 1, version 2.0, uncompressed, LZ4, BZ2; topics of `dvs_msgs/EventArray` and of "
      "`event_camera_msgs/EventPacket` (mono, libcaer, libcaer_cmp, evt2, evt3), the first two as cameras, "
      "`left` and `right` by name, merged by time";
  format.writes =
      "`dvs_msgs/EventArray` on `/dvs/events`, of two cameras on `/dvs/left/events` and `/dvs/right/events`; "
      "`event_camera_msgs/EventPacket` (mono) as `NAME.packets.bag`";
  format.time = "ns, to the nearest us; evt2 34, evt3 24 bits of us";
  format.axes = "top left, 1 is ON";
  format.limits = "times from 0 to 2^32 s";
  return format;
}

}  // namespace saccade
