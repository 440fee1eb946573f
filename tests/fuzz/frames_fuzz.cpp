// Any bytes as the stream of a robot, or of a client, of external/robot_frames.h: every frame is read or named, with no more
// values than bytes.
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <span>

#include "external/robot_frames.h"

namespace saccade {
namespace {

void require(bool condition) {
  if (!condition) std::abort();
}

void read_any(const FrameView& frame) {
  RobotHello hello;
  if (read_hello(frame.payload, hello).empty()) {
    require(hello.image_size.width > 0 && hello.image_size.height > 0);
    require(hello.joints.size() <= static_cast<std::size_t>(joint_slots));
    for (const RobotHello::Joint& joint : hello.joints) require(joint.min_rad < joint.max_rad);
  }
  std::int64_t until_us = 0;
  std::vector<Event> events;
  (void)read_events(frame.payload, until_us, events);
  require(16 * events.size() <= frame.payload.size());
  JointsFrame joints;
  for (int count = 0; count <= joint_slots; ++count) {
    if (!read_joints(frame.payload, count, joints).empty()) continue;
    require(joints.count == count);
  }
  ImuReading reading;
  (void)read_imu(frame.payload, reading);
  std::string text;
  (void)read_text(frame.payload, text);
  require(text.size() <= most_text_bytes);
  RobotClient client{};
  (void)read_client(frame.payload, client);
  std::uint64_t number = 0;
  std::array<double, gaze_slots> reference_rad{};
  for (int count = 0; count <= gaze_slots; ++count)
    (void)read_reference(frame.payload, count, number, reference_rad);
  (void)read_number(frame.payload, number);
}

}  // namespace
}  // namespace saccade

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace saccade;
  if (size == 0) return 0;
  const std::size_t step = 1 + data[0];  // bytes come in pieces
  FrameReader reader;
  for (std::size_t at = 1; at < size; at += step) {
    const std::size_t count = std::min(step, size - at);
    std::memcpy(reader.room().data(), data + at, count);
    reader.received(count);
    while (const auto frame = reader.next()) read_any(*frame);
  }
  return 0;
}
