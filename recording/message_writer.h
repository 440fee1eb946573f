#pragma once

#include <array>
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

/// Base of the writers of files that hold ROS messages: gathers the events of each camera into messages of up to 8192 events
/// and 10 ms.
class MessageWriter : public EventWriter {
 public:
  void write(std::span<const Event> events) final;
  void sync() final;
  void commit() final;

 protected:
  /// `largest_us`: the latest time that the messages can hold.
  MessageWriter(const std::filesystem::path& path, ImageSize image_size, int cameras, std::int64_t largest_us)
      : file_(path), image_size_(image_size), cameras_(cameras), largest_us_(largest_us) {}

  /// Writes a message of these events of one camera, at least one, none earlier than the first and none more than 10 ms
  /// after it. `seq`: number of the camera's message, from 0 on. `last_ns`: time of the latest event.
  virtual void put_message(int camera, std::span<const Event> events, std::uint32_t seq,
                           std::uint64_t last_ns) = 0;
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
  [[nodiscard]] int cameras() const { return cameras_; }
  /// `/dvs/events`; of two cameras `/dvs/left/events` and `/dvs/right/events`.
  [[nodiscard]] std::string topic(std::string_view device, int camera) const;

  OutputFile file_;

 private:
  struct Side {
    std::vector<Event> pending;
    std::uint32_t seq = 0;
  };
  void flush(int camera);

  ImageSize image_size_;
  int cameras_;
  std::int64_t largest_us_;
  std::uint64_t offset_ = 0;
  std::array<Side, 2> sides_;  ///< by camera
};

/// The latest time that a ROS 2 message's stamp holds: i32 s.
inline constexpr std::int64_t largest_ros2_stamp_us = 2147483647LL * 1'000'000;

/// Throws InputError for an image whose rows an EventPacket of encoding mono cannot number.
void check_packet_size(const std::filesystem::path& path, ImageSize image_size);

}  // namespace saccade
