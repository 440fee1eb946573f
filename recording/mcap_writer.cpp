#include "recording/event_message.h"
#include "recording/mcap_codec.h"
#include "recording/mcap_file.h"
#include "recording/message_writer.h"

namespace saccade {
namespace {

class McapWriter final : public MessageWriter {
 public:
  McapWriter(const std::filesystem::path& path, ImageSize image_size, int cameras)
      : MessageWriter(path, image_size, cameras, largest_ros2_stamp_us), mcap_(file_, "ros2") {
    const std::uint16_t schema = mcap_.add_schema("event_camera_msgs/msg/EventPacket", "ros2msg",
                                                  event_packet_definition(Serialisation::cdr));
    for (int camera = 0; camera < cameras; ++camera)
      mcap_.add_channel(schema, topic("event_camera", camera), "cdr");
  }

 protected:
  void put_message(int camera, std::span<const Event> events, std::uint32_t seq,
                   std::uint64_t last_ns) override {
    std::string message;
    append_event_packet(message, events, image_size(), seq, Serialisation::cdr);
    mcap_.write({.channel = static_cast<std::uint16_t>(camera),
                 .sequence = seq,
                 .log_ns = last_ns,
                 .publish_ns = static_cast<std::uint64_t>(events.front().t_us) * 1000},
                message);
  }
  void put_chunk() override { mcap_.end_chunk(); }
  void finish() override { mcap_.finish(); }

 private:
  McapFile mcap_;  ///< its channels are the cameras
};

}  // namespace

std::unique_ptr<EventWriter> create_mcap(const std::filesystem::path& path, ImageSize image_size,
                                         int cameras) {
  check_packet_size(path, image_size);
  return std::make_unique<McapWriter>(path, image_size, cameras);
}

}  // namespace saccade
