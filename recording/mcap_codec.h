#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string_view>

#include "recording/format_registry.h"

namespace saccade {

/// MCAP files (mcap.dev/spec): 8 bytes of mark, records, the mark again. A record is u8 opcode, u64 and that many bytes.
/// Schemas, channels and messages lie between other records or in chunks, compressed as the chunk says (none, lz4: a frame,
/// zstd); after DataEnd comes an index, then the footer. Messages of events: recording/event_message.h, in ROS 1's or
/// ROS 2's serialisation as the channel says.
///
/// The checksum of a chunk is compared where the file has one. A file without its footer is an InputError after the events.
///
/// The writer makes event_camera_msgs/msg/EventPacket (mono) in CDR, up to 8192 events and 10 ms each, on the topic
/// `/event_camera/events`, of two cameras `/event_camera/left/events` and `/event_camera/right/events`, in chunks of about
/// 1 MiB compressed with ZSTD, with indices. It throws InputError for times outside [0, 2^31) s.
[[nodiscard]] RecordingFormat mcap_format();

[[nodiscard]] std::unique_ptr<EventWriter> create_mcap(const std::filesystem::path& path,
                                                       ImageSize image_size, int cameras);

inline constexpr std::string_view mcap_mark = "\x89MCAP0\r\n";

/// Opcodes of records.
enum class McapOp : std::uint8_t {
  header = 1,
  footer = 2,
  schema = 3,
  channel = 4,
  message = 5,
  chunk = 6,
  message_index = 7,
  chunk_index = 8,
  statistics = 11,
  summary_offset = 14,
  data_end = 15,
};

}  // namespace saccade
