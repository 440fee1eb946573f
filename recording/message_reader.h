#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "recording/block_reader.h"
#include "recording/event_message.h"
#include "recording/sensor_message.h"
#include "recording/unpacked_part.h"

namespace saccade {

/// Base of the readers of files that hold ROS messages on topics, in parts that may be compressed.
///
/// The first topic with events is camera 0, a second one camera 1; a topic with `right` in its name is always camera 1, one
/// with `left` camera 0. Messages of further topics with events and of types that nobody wants are skipped and counted. The events
/// of two cameras are merged by time, camera 0 first where times are equal; each camera keeps its order. A camera is
/// not waited for once 2^18 events of the other one have been read ahead.
class MessageReader : public BlockReader {
 public:
  std::optional<ImageSize> image_size() const override;
  std::string format() const override;
  std::string skipped() const override;
  std::optional<std::int64_t> host_ahead_us() const override { return host_ahead_us_; }

 protected:
  static constexpr std::size_t most_message_bytes = 1 << 26;
  static constexpr std::size_t most_header_bytes = 1 << 20;
  static constexpr std::size_t most_ahead = 1 << 18;  ///< events

  /// `container`: for format().
  MessageReader(InputFile file, std::string container, const EventReadOptions& options);

  /// Reads on until a message that wants() accepted was passed to take(); false at the end of the file. Throws InputError for broken
  /// content.
  virtual bool next() = 0;

  /// Reads messages until there are events to give out, or none come any more. The last call of a constructor, so that the
  /// image size is known.
  void read_ahead();
  /// A topic is announced. `id`: of the container. Announcing one again changes nothing.
  void add_topic(std::uint32_t id, const std::string& name, const std::string& type,
                 Serialisation serialisation);
  /// Whether take() must get the messages of that topic; counts a message of another one.
  [[nodiscard]] bool wants(std::uint32_t id);
  /// A message on a topic that wants() accepted. `host_ns`: when it was recorded.
  void take(std::uint32_t id, std::string_view message, std::uint64_t host_ns);
  /// A decompressor for a part compressed so ("none", "", "lz4", "bz2", "zstd"). Throws InputError for another word.
  [[nodiscard]] std::unique_ptr<Decompressor> decompressor(const std::string& word);

  bool decode(std::span<Event> block, std::size_t& count) final;

  UnpackedPart part_{file_};

 private:
  struct Topic {
    std::string name, type;
    std::optional<EventMessageDecoder> decoder;
    std::optional<SensorMessageType> sensor;  ///< without a decoder and this its messages are skipped
    Serialisation serialisation = Serialisation::ros1;
    std::uint8_t camera = 0;
    std::int64_t skipped = 0;
  };
  /// Events of a camera; those from `next` on are not yet read.
  struct Queue {
    std::vector<Event> events;
    std::size_t next = 0;
    bool has_topic = false;
    [[nodiscard]] std::size_t size() const { return events.size() - next; }
  };

  [[nodiscard]] bool needs_message() const;
  /// What is broken is told after the events before it.
  void keep(const std::optional<BrokenMessage>& broken);

  std::string container_;
  std::optional<ImageSize> size_option_;
  OtherRecords* others_;
  std::string compression_;
  std::map<std::uint32_t, Topic> topics_;
  std::array<Queue, 2> queues_;  ///< by camera
  bool over_ = false;
  std::optional<std::int64_t> host_ahead_us_;
  std::optional<InputError> failure_;  ///< thrown after the events before it
};

}  // namespace saccade
