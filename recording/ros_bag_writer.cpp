#include <algorithm>
#include <array>
#include <limits>

#include "recording/byte_order.h"
#include "recording/event_message.h"
#include "recording/message_writer.h"
#include "recording/ros_bag_codec.h"

namespace saccade {
namespace {

constexpr std::string_view bag_line = "#ROSBAG V2.0\n";
constexpr std::size_t enough_bag_chunk_bytes = 768 * 1024;
constexpr std::size_t file_header_bytes = 4096;                    ///< fields, padding included
constexpr std::int64_t largest_bag_us = 4294967295LL * 1'000'000;  ///< u32 s

/// The time of a record, u32 s and u32 ns.
std::uint64_t bag_time(std::uint64_t ns) { return ns / 1'000'000'000 | ns % 1'000'000'000 << 32; }

template <std::integral T>
std::string field(std::string_view name, T value) {
  std::string bytes;
  append_little(bytes, static_cast<std::uint32_t>(name.size() + 1 + sizeof(T)));
  bytes += name;
  bytes += '=';
  append_little(bytes, value);
  return bytes;
}
std::string field(std::string_view name, std::string_view value) {
  std::string bytes;
  append_little(bytes, static_cast<std::uint32_t>(name.size() + 1 + value.size()));
  return bytes.append(name).append("=").append(value);
}

std::string record(std::string_view fields, std::string_view data) {
  std::string bytes;
  append_little(bytes, static_cast<std::uint32_t>(fields.size()));
  bytes += fields;
  append_little(bytes, static_cast<std::uint32_t>(data.size()));
  return bytes.append(data);
}

class RosBagWriter final : public MessageWriter {
 public:
  RosBagWriter(const std::filesystem::path& path, ImageSize image_size, int cameras, bool packets)
      : MessageWriter(path, image_size, cameras, largest_bag_us), packets_(packets) {
    put(bag_line);
    put(file_header(0));
  }

 protected:
  void put_message(int camera, std::span<const Event> events, std::uint32_t seq,
                   std::uint64_t last_ns) override {
    if (chunk_.empty()) {
      chunk_ = connections();
      first_ns_ = std::numeric_limits<std::uint64_t>::max();
      last_ns_ = 0;
    }
    first_ns_ = std::min(first_ns_, last_ns);
    last_ns_ = std::max(last_ns_, last_ns);
    Index& index = indices_[static_cast<std::size_t>(camera)];
    append_little(index.bytes, bag_time(last_ns));
    append_little(index.bytes, static_cast<std::uint32_t>(chunk_.size()));
    ++index.messages;
    std::string message;
    if (packets_) {
      append_event_packet(message, events, image_size(), seq, Serialisation::ros1);
    } else {
      append_event_array(message, events, image_size(), seq);
    }
    chunk_ += record(
        field("op", std::uint8_t{2}) + field("conn", number_of(camera)) + field("time", bag_time(last_ns)),
        message);
    if (chunk_.size() >= enough_bag_chunk_bytes) put_chunk();
  }

  void put_chunk() override {
    if (chunk_.empty()) return;
    std::string counts;
    std::uint32_t used = 0;
    for (int camera = 0; camera < cameras(); ++camera) {
      const std::uint32_t messages = indices_[static_cast<std::size_t>(camera)].messages;
      if (messages == 0) continue;
      append_little(counts, number_of(camera));
      append_little(counts, messages);
      ++used;
    }
    const std::string infos_fields = field("op", std::uint8_t{6}) + field("ver", std::uint32_t{1}) +
                                     field("chunk_pos", offset()) + field("start_time", bag_time(first_ns_)) +
                                     field("end_time", bag_time(last_ns_)) + field("count", used);
    chunk_infos_ += record(infos_fields, counts);
    put(record(field("op", std::uint8_t{5}) + field("compression", std::string_view("none")) +
                   field("size", static_cast<std::uint32_t>(chunk_.size())),
               chunk_));
    for (int camera = 0; camera < cameras(); ++camera) {
      Index& index = indices_[static_cast<std::size_t>(camera)];
      if (index.messages == 0) continue;
      put(record(field("op", std::uint8_t{4}) + field("ver", std::uint32_t{1}) +
                     field("conn", number_of(camera)) + field("count", index.messages),
                 index.bytes));
      index = {};
    }
    ++chunks_;
    chunk_.clear();
  }

  void finish() override {
    put_chunk();
    const std::uint64_t index_pos = offset();
    if (chunks_ > 0) put(connections());
    put(chunk_infos_);
    const std::string header = file_header(index_pos);
    file_.overwrite(static_cast<std::int64_t>(bag_line.size()), std::as_bytes(std::span(header)));
  }

 private:
  [[nodiscard]] std::string file_header(std::uint64_t index_pos) const {
    const std::string fields = field("op", std::uint8_t{3}) + field("index_pos", index_pos) +
                               field("conn_count", chunks_ > 0 ? number_of(cameras()) : 0u) +
                               field("chunk_count", chunks_);
    return record(fields, std::string(file_header_bytes - fields.size(), ' '));
  }

  /// Of a camera's connection.
  [[nodiscard]] static std::uint32_t number_of(int camera) { return static_cast<std::uint32_t>(camera); }

  [[nodiscard]] std::string connections() const {
    std::string records;
    for (int camera = 0; camera < cameras(); ++camera) records += connection(camera);
    return records;
  }

  [[nodiscard]] std::string connection(int camera) const {
    const std::string type = packets_ ? "event_camera_msgs/EventPacket" : "dvs_msgs/EventArray";
    const std::string name = topic("dvs", camera);
    return record(field("op", std::uint8_t{7}) + field("conn", number_of(camera)) + field("topic", name),
                  field("topic", name) + field("type", type) +
                      field("md5sum", packets_ ? event_packet_md5 : event_array_md5) +
                      field("message_definition", packets_ ? event_packet_definition(Serialisation::ros1)
                                                           : event_array_definition()));
  }

  /// Of a camera's messages in the chunk: time, offset.
  struct Index {
    std::string bytes;
    std::uint32_t messages = 0;
  };

  bool packets_;
  std::string chunk_;  ///< records
  std::array<Index, 2> indices_;
  std::uint64_t first_ns_ = 0, last_ns_ = 0;
  std::uint32_t chunks_ = 0;  ///< written
  std::string chunk_infos_;   ///< of those
};

}  // namespace

std::unique_ptr<EventWriter> create_ros_bag(const std::filesystem::path& path, ImageSize image_size,
                                            int cameras) {
  const bool packets = path.stem().extension() == ".packets";
  if (packets) check_packet_size(path, image_size);
  return std::make_unique<RosBagWriter>(path, image_size, cameras, packets);
}

}  // namespace saccade
