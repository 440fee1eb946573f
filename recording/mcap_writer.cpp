#include <zlib.h>
#include <zstd.h>

#include <algorithm>
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
constexpr std::uint16_t channel_id = 0;

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
  std::uint64_t first_ns = 0, last_ns = 0, place = 0, bytes = 0, index_place = 0, index_bytes = 0, stored = 0,
                unpacked = 0;
};

class McapWriter final : public MessageWriter {
 public:
  McapWriter(const std::filesystem::path& path, ImageSize image_size)
      : MessageWriter(path, image_size, largest_stamp_us) {
    put(mcap_mark);
    put(McapBytes().text("ros2").text("saccade").record(McapOp::header));
  }

 protected:
  void put_message(std::span<const Event> events, std::uint32_t seq, std::uint64_t last_ns) override {
    if (chunk_.empty()) {
      chunk_ = topic_records();
      entry_ = {};
      entry_.first_ns = std::numeric_limits<std::uint64_t>::max();
    }
    entry_.first_ns = std::min(entry_.first_ns, last_ns);
    entry_.last_ns = std::max(entry_.last_ns, last_ns);
    append_little(index_, last_ns);
    append_little(index_, static_cast<std::uint64_t>(chunk_.size()));
    std::string message;
    append_event_packet(message, events, image_size(), seq, Serialisation::cdr);
    const std::uint64_t stamp_ns = static_cast<std::uint64_t>(events.front().t_us) * 1000;
    chunk_ += McapBytes()
                  .number(channel_id)
                  .number(seq)
                  .number(last_ns)
                  .number(stamp_ns)
                  .raw(message)
                  .record(McapOp::message);
    ++messages_;
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
    entry_.index_place = offset();
    put(McapBytes().number(channel_id).text(index_).record(McapOp::message_index));
    entry_.index_bytes = offset() - entry_.index_place;
    chunks_.push_back(entry_);
    chunk_.clear();
    index_.clear();
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
    put_group(McapOp::channel, channel_record());
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
  [[nodiscard]] static std::string channel_record() {
    return McapBytes()
        .number(channel_id)
        .number(schema_id)
        .text("/event_camera/events")
        .text("cdr")
        .number(std::uint32_t{0})  // bytes of metadata
        .record(McapOp::channel);
  }
  [[nodiscard]] static std::string topic_records() { return schema_record() + channel_record(); }

  [[nodiscard]] std::string statistics_record() const {
    std::uint64_t first_ns = chunks_.empty() ? 0 : chunks_.front().first_ns;
    std::uint64_t last_ns = 0;
    for (const ChunkEntry& chunk : chunks_) {
      first_ns = std::min(first_ns, chunk.first_ns);
      last_ns = std::max(last_ns, chunk.last_ns);
    }
    return McapBytes()
        .number(messages_)
        .number(std::uint16_t{1})
        .number(std::uint32_t{1})
        .number(std::uint32_t{0})
        .number(std::uint32_t{0})
        .number(static_cast<std::uint32_t>(chunks_.size()))
        .number(first_ns)
        .number(last_ns)
        .number(std::uint32_t{10})  // bytes of the map
        .number(channel_id)
        .number(messages_)
        .record(McapOp::statistics);
  }

  [[nodiscard]] std::string chunk_index_records() const {
    std::string records;
    for (const ChunkEntry& chunk : chunks_) {
      records += McapBytes()
                     .number(chunk.first_ns)
                     .number(chunk.last_ns)
                     .number(chunk.place)
                     .number(chunk.bytes)
                     .number(std::uint32_t{10})  // bytes of the map
                     .number(channel_id)
                     .number(chunk.index_place)
                     .number(chunk.index_bytes)
                     .text("zstd")
                     .number(chunk.stored)
                     .number(chunk.unpacked)
                     .record(McapOp::chunk_index);
    }
    return records;
  }

  std::string chunk_;  ///< records
  std::string index_;  ///< of its messages: time, offset
  ChunkEntry entry_;   ///< of it
  std::vector<ChunkEntry> chunks_;
  std::uint64_t messages_ = 0;
};

}  // namespace

std::unique_ptr<EventWriter> create_mcap(const std::filesystem::path& path, ImageSize image_size,
                                         int /*cameras*/) {
  check_packet_size(path, image_size);
  return std::make_unique<McapWriter>(path, image_size);
}

}  // namespace saccade
