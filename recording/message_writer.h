#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/event.h"
#include "recording/event_file.h"
#include "recording/output_file.h"

namespace saccade {

/// Base of the writers of files that hold ROS messages: gathers events into messages of up to 8192 events and 10 ms.
class MessageWriter : public EventWriter {
 public:
  void write(std::span<const Event> events) final;
  void sync() final;
  void commit() final;

 protected:
  /// `largest_us`: the latest time that the messages can hold.
  MessageWriter(const std::filesystem::path& path, ImageSize image_size, std::int64_t largest_us)
      : file_(path), image_size_(image_size), largest_us_(largest_us) {}

  /// Writes a message of these events, at least one, none earlier than the first and none more than 10 ms after it.
  /// `seq`: number of the message, from 0 on. `last_ns`: time of the latest event.
  virtual void put_message(std::span<const Event> events, std::uint32_t seq, std::uint64_t last_ns) = 0;
  /// Writes the messages that are not in the file yet.
  virtual void put_chunk() = 0;
  /// Writes what comes after the last message.
  virtual void finish() = 0;

  void put(std::string_view bytes) {
    file_.write(bytes);
    offset_ += bytes.size();
  }
  [[nodiscard]] std::uint64_t offset() const { return offset_; }
  [[nodiscard]] ImageSize image_size() const { return image_size_; }

  OutputFile file_;

 private:
  void flush();

  ImageSize image_size_;
  std::int64_t largest_us_;
  std::uint64_t offset_ = 0;
  std::vector<Event> pending_;
  std::uint32_t seq_ = 0;
};

/// Throws InputError for an image whose rows an EventPacket of encoding mono cannot number.
void check_packet_size(const std::filesystem::path& path, ImageSize image_size);

}  // namespace saccade
