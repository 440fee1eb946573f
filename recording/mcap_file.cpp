#include "recording/mcap_file.h"

#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <concepts>
#include <limits>

#include "core/error.h"
#include "recording/byte_order.h"
#include "recording/mcap_codec.h"

namespace saccade {
namespace {

constexpr std::size_t enough_chunk_bytes = 1 << 20;
constexpr int compression_level = 1;

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

}  // namespace

McapFile::McapFile(OutputFile& file, std::string_view profile) : file_(file) {
  put(mcap_mark);
  put(McapBytes().text(profile).text("saccade").record(McapOp::header));
}

void McapFile::put(std::string_view bytes) {
  file_.write(bytes);
  offset_ += bytes.size();
}

std::uint16_t McapFile::add_schema(std::string_view name, std::string_view encoding, std::string_view text) {
  SACCADE_CHECK(chunk_.empty() && chunks_.empty());
  ++schemas_;
  schema_records_ += McapBytes().number(schemas_).text(name).text(encoding).text(text).record(McapOp::schema);
  return schemas_;
}

std::uint16_t McapFile::add_channel(std::uint16_t schema, std::string_view topic, std::string_view encoding) {
  SACCADE_CHECK(chunk_.empty() && chunks_.empty());
  const auto channel = static_cast<std::uint16_t>(channels_.size());
  channels_.emplace_back();
  channel_records_ += McapBytes()
                          .number(channel)
                          .number(schema)
                          .text(topic)
                          .text(encoding)
                          .number(std::uint32_t{0})  // bytes of metadata
                          .record(McapOp::channel);
  return channel;
}

void McapFile::write(const Message& message, std::string_view content) {
  if (chunk_.empty()) {
    chunk_ = schema_records_ + channel_records_;
    entry_ = {};
    entry_.first_ns = std::numeric_limits<std::uint64_t>::max();
  }
  entry_.first_ns = std::min(entry_.first_ns, message.log_ns);
  entry_.last_ns = std::max(entry_.last_ns, message.log_ns);
  Channel& channel = channels_.at(message.channel);
  append_little(channel.index, message.log_ns);
  append_little(channel.index, static_cast<std::uint64_t>(chunk_.size()));
  chunk_ += McapBytes()
                .number(message.channel)
                .number(message.sequence)
                .number(message.log_ns)
                .number(message.publish_ns)
                .raw(content)
                .record(McapOp::message);
  ++channel.messages;
  if (chunk_.size() >= enough_chunk_bytes) end_chunk();
}

void McapFile::end_chunk() {
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
  entry_.place = offset_;
  put(McapBytes()
          .number(entry_.first_ns)
          .number(entry_.last_ns)
          .number(entry_.unpacked)
          .number(crc)
          .text("zstd")
          .number(entry_.stored)
          .raw(packed)
          .record(McapOp::chunk));
  entry_.bytes = offset_ - entry_.place;
  const std::uint64_t indices_place = offset_;
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    std::string& index = channels_[i].index;
    if (index.empty()) continue;
    const auto channel = static_cast<std::uint16_t>(i);
    entry_.index_places[channel] = offset_;
    put(McapBytes().number(channel).text(index).record(McapOp::message_index));
    index.clear();
  }
  entry_.index_bytes = offset_ - indices_place;
  chunks_.push_back(std::move(entry_));
  chunk_.clear();
}

void McapFile::finish() {
  end_chunk();
  put(McapBytes().number(std::uint32_t{0}).record(McapOp::data_end));
  const std::uint64_t summary = offset_;
  std::string offsets;
  const auto put_group = [&](McapOp op, std::string_view records) {
    if (records.empty()) return;
    offsets += McapBytes()
                   .number(static_cast<std::uint8_t>(op))
                   .number(offset_)
                   .number(static_cast<std::uint64_t>(records.size()))
                   .record(McapOp::summary_offset);
    put(records);
  };
  put_group(McapOp::schema, schema_records_);
  put_group(McapOp::channel, channel_records_);
  put_group(McapOp::statistics, statistics_record());
  put_group(McapOp::chunk_index, chunk_index_records());
  const std::uint64_t summary_offset = offset_;
  put(offsets);
  put(McapBytes().number(summary).number(summary_offset).number(std::uint32_t{0}).record(McapOp::footer));
  put(mcap_mark);
}

std::string McapFile::statistics_record() const {
  std::uint64_t first_ns = chunks_.empty() ? 0 : chunks_.front().first_ns;
  std::uint64_t last_ns = 0;
  for (const Chunk& chunk : chunks_) {
    first_ns = std::min(first_ns, chunk.first_ns);
    last_ns = std::max(last_ns, chunk.last_ns);
  }
  std::uint64_t messages = 0;
  McapBytes counts;
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    messages += channels_[i].messages;
    counts.number(static_cast<std::uint16_t>(i)).number(channels_[i].messages);
  }
  return McapBytes()
      .number(messages)
      .number(schemas_)
      .number(static_cast<std::uint32_t>(channels_.size()))
      .number(std::uint32_t{0})
      .number(std::uint32_t{0})
      .number(static_cast<std::uint32_t>(chunks_.size()))
      .number(first_ns)
      .number(last_ns)
      .text(counts.bytes())
      .record(McapOp::statistics);
}

std::string McapFile::chunk_index_records() const {
  std::string records;
  for (const Chunk& chunk : chunks_) {
    McapBytes places;
    for (const auto& [channel, place] : chunk.index_places) places.number(channel).number(place);
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

}  // namespace saccade
