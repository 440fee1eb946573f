#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <limits>

#include "core/error.h"
#include "recording/byte_order.h"
#include "recording/event_message.h"
#include "recording/mcap_codec.h"
#include "recording/message_writer.h"

namespace saccade {
namespace {

constexpr std::size_t enough_chunk_bytes = 1 << 20;
constexpr int compression_level = 1;
constexpr std::int64_t largest_stamp_us = 2147483647LL * 1'000'000;  ///< i32 s
constexpr std::uint16_t schema_id = 1;

/// The bytes of a record's members.
class McapBytes {
 public:
  template <std::integral T>
  McapBytes& number(T value) {
    append_little(bytes_, value);
    return *this;
  }
  McapBytes& text(std::string_view value) {
    append_little(bytes_, static_cast<std::uint32_t>(value.size()));
    bytes_ += value;
    return *this;
  }
  McapBytes& raw(std::string_view value) {
    bytes_ += value;
    return *this;
  }
  [[nodiscard]] const std::string& bytes() const { return bytes_; }
  /// The whole record.
  [[nodiscard]] std::string record(McapOp op) const {
    std::string record(1, static_cast<char>(op));
    append_little(record, static_cast<std::uint64_t>(bytes_.size()));
    return record + bytes_;
  }

 private:
  std::string bytes_;
};

struct ChunkEntry {
  std::uint64_t first_ns = 0, last_ns = 0, place = 0, bytes = 0, index_bytes = 0, stored = 0, unpacked = 0;
  std::array<std::uint64_t, 2> index_places{};  ///< of the cameras' indices; 0: none
};

class McapWriter final : public MessageWriter {
 public:
  McapWriter(const std::filesystem::path& path, ImageSize image_size, int cameras)
      : MessageWriter(path, image_size, cameras, largest_stamp_us) {
    put(mcap_mark);
    put(McapBytes().text("ros2").text("saccade").record(McapOp::header));
  }

 protected:
  void put_message(int camera, std::span<const Event> events, std::uint32_t seq,
                   std::uint64_t last_ns) override {
    if (chunk_.empty()) {
      chunk_ = topic_records();
      entry_ = {};
      entry_.first_ns = std::numeric_limits<std::uint64_t>::max();
    }
    entry_.first_ns = std::min(entry_.first_ns, last_ns);
    entry_.last_ns = std::max(entry_.last_ns, last_ns);
    std::string& index = indices_[static_cast<std::size_t>(camera)];
    append_little(index, last_ns);
    append_little(index, static_cast<std::uint64_t>(chunk_.size()));
    std::string message;
    append_event_packet(message, events, image_size(), seq, Serialisation::cdr);
    const std::uint64_t stamp_ns = static_cast<std::uint64_t>(events.front().t_us) * 1000;
    chunk_ += McapBytes()
                  .number(channel_of(camera))
                  .number(seq)
                  .number(last_ns)
                  .number(stamp_ns)
                  .raw(message)
                  .record(McapOp::message);
    ++messages_[static_cast<std::size_t>(camera)];
    if (chunk_.size() >= enough_chunk_bytes) put_chunk();
  }

  void put_chunk() override {
    if (chunk_.empty()) return;
    std::string packed(ZSTD_compressBound(chunk_.size()), '\0');
    const std::size_t size =
        ZSTD_compress(packed.data(), packed.size(), chunk_.data(), chunk_.size(), compression_level);
    SACCADE_CHECK(ZSTD_isError(size) == 0);
    packed.resize(size);
    const auto crc = static_cast<std::uint32_t>(
        crc32(0, reinterpret_cast<const Bytef*>(chunk_.data()), static_cast<uInt>(chunk_.size())));
    entry_.unpacked = chunk_.size();
    entry_.stored = packed.size();
    entry_.place = offset();
    put(McapBytes()
            .number(entry_.first_ns)
            .number(entry_.last_ns)
            .number(entry_.unpacked)
            .number(crc)
            .text("zstd")
            .number(entry_.stored)
            .raw(packed)
            .record(McapOp::chunk));
    entry_.bytes = offset() - entry_.place;
    const std::uint64_t indices_place = offset();
    for (int camera = 0; camera < cameras(); ++camera) {
      std::string& index = indices_[static_cast<std::size_t>(camera)];
      if (index.empty()) continue;
      entry_.index_places[static_cast<std::size_t>(camera)] = offset();
      put(McapBytes().number(channel_of(camera)).text(index).record(McapOp::message_index));
      index.clear();
    }
    entry_.index_bytes = offset() - indices_place;
    chunks_.push_back(entry_);
    chunk_.clear();
  }

  void finish() override {
    put_chunk();
    put(McapBytes().number(std::uint32_t{0}).record(McapOp::data_end));
    const std::uint64_t summary = offset();
    std::string offsets;
    const auto put_group = [&](McapOp op, std::string_view records) {
      if (records.empty()) return;
      offsets += McapBytes()
                     .number(static_cast<std::uint8_t>(op))
                     .number(offset())
                     .number(static_cast<std::uint64_t>(records.size()))
                     .record(McapOp::summary_offset);
      put(records);
    };
    put_group(McapOp::schema, schema_record());
    put_group(McapOp::channel, channel_records());
    put_group(McapOp::statistics, statistics_record());
    put_group(McapOp::chunk_index, chunk_index_records());
    const std::uint64_t summary_offset = offset();
    put(offsets);
    put(McapBytes().number(summary).number(summary_offset).number(std::uint32_t{0}).record(McapOp::footer));
    put(mcap_mark);
  }

 private:
  [[nodiscard]] static std::string schema_record() {
    return McapBytes()
        .number(schema_id)
        .text("event_camera_msgs/msg/EventPacket")
        .text("ros2msg")
        .text(event_packet_definition(Serialisation::cdr))
        .record(McapOp::schema);
  }
  [[nodiscard]] static std::uint16_t channel_of(int camera) { return static_cast<std::uint16_t>(camera); }
  [[nodiscard]] std::string channel_records() const {
    std::string records;
    for (int camera = 0; camera < cameras(); ++camera) {
      records += McapBytes()
                     .number(channel_of(camera))
                     .number(schema_id)
                     .text(topic("event_camera", camera))
                     .text("cdr")
                     .number(std::uint32_t{0})  // bytes of metadata
                     .record(McapOp::channel);
    }
    return records;
  }
  [[nodiscard]] std::string topic_records() const { return schema_record() + channel_records(); }

  [[nodiscard]] std::string statistics_record() const {
    std::uint64_t first_ns = chunks_.empty() ? 0 : chunks_.front().first_ns;
    std::uint64_t last_ns = 0;
    for (const ChunkEntry& chunk : chunks_) {
      first_ns = std::min(first_ns, chunk.first_ns);
      last_ns = std::max(last_ns, chunk.last_ns);
    }
    McapBytes counts;
    for (int camera = 0; camera < cameras(); ++camera)
      counts.number(channel_of(camera)).number(messages_[static_cast<std::size_t>(camera)]);
    return McapBytes()
        .number(messages_[0] + messages_[1])
        .number(std::uint16_t{1})
        .number(static_cast<std::uint32_t>(cameras()))
        .number(std::uint32_t{0})
        .number(std::uint32_t{0})
        .number(static_cast<std::uint32_t>(chunks_.size()))
        .number(first_ns)
        .number(last_ns)
        .text(counts.bytes())
        .record(McapOp::statistics);
  }

  [[nodiscard]] std::string chunk_index_records() const {
    std::string records;
    for (const ChunkEntry& chunk : chunks_) {
      McapBytes places;
      for (int camera = 0; camera < cameras(); ++camera) {
        const std::uint64_t place = chunk.index_places[static_cast<std::size_t>(camera)];
        if (place != 0) places.number(channel_of(camera)).number(place);
      }
      records += McapBytes()
                     .number(chunk.first_ns)
                     .number(chunk.last_ns)
                     .number(chunk.place)
                     .number(chunk.bytes)
                     .text(places.bytes())
                     .number(chunk.index_bytes)
                     .text("zstd")
                     .number(chunk.stored)
                     .number(chunk.unpacked)
                     .record(McapOp::chunk_index);
    }
    return records;
  }

  std::string chunk_;                   ///< records
  std::array<std::string, 2> indices_;  ///< of the cameras' messages in it: time, offset
  ChunkEntry entry_;                    ///< of it
  std::vector<ChunkEntry> chunks_;
  std::array<std::uint64_t, 2> messages_{};  ///< by camera
};

}  // namespace

std::unique_ptr<EventWriter> create_mcap(const std::filesystem::path& path, ImageSize image_size,
                                         int cameras) {
  check_packet_size(path, image_size);
  return std::make_unique<McapWriter>(path, image_size, cameras);
}

}  // namespace saccade
