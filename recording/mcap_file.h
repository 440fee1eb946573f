#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "recording/output_file.h"

namespace saccade {

/// The records of an MCAP file (recording/mcap_codec.h): schemas and channels, then messages in chunks of about 1 MiB
/// compressed with ZSTD, each with the schemas and channels in front, then an index. Every member throws RunError where
/// writing fails.
class McapFile {
 public:
  /// `file`: empty, and outlives this object. `profile`: ros2, or empty.
  McapFile(OutputFile& file, std::string_view profile);

  /// Returns the schema's number, from 1 on. Schemas and channels are added before the first message.
  std::uint16_t add_schema(std::string_view name, std::string_view encoding, std::string_view text);
  /// Returns the channel's number, from 0 on. `encoding`: of its messages.
  std::uint16_t add_channel(std::uint16_t schema, std::string_view topic, std::string_view encoding);

  struct Message {
    std::uint16_t channel = 0;
    std::uint32_t sequence = 0;
    std::uint64_t log_ns = 0;      ///< by which readers sort
    std::uint64_t publish_ns = 0;  ///< what the message says of itself
  };
  void write(const Message& message, std::string_view content);
  /// Ends the chunk: what was written so far can be read.
  void end_chunk();
  /// Writes index, footer and mark; nothing is written after it.
  void finish();

 private:
  struct Channel {
    std::string index;  ///< of its messages in the chunk: time, offset
    std::uint64_t messages = 0;
  };
  struct Chunk {
    std::uint64_t first_ns = 0, last_ns = 0, place = 0, bytes = 0, index_bytes = 0, stored = 0, unpacked = 0;
    std::map<std::uint16_t, std::uint64_t> index_places;  ///< by channel
  };

  void put(std::string_view bytes);
  [[nodiscard]] std::string statistics_record() const;
  [[nodiscard]] std::string chunk_index_records() const;

  OutputFile& file_;
  std::uint64_t offset_ = 0;
  std::uint16_t schemas_ = 0;
  std::string schema_records_;
  std::string channel_records_;
  std::vector<Channel> channels_;
  std::string chunk_;  ///< records
  Chunk entry_;        ///< of it
  std::vector<Chunk> chunks_;
};

}  // namespace saccade
