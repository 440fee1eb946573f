// Any bytes as a message of a camera, of joints, or of a client of serve: they are rejected, or have no more values than
// bytes.
#include <array>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "robot/bottle.h"
#include "robot/event_packet.h"
#include "robot/number_list.h"

namespace saccade {
namespace {

void require(bool condition) {
  if (!condition) std::abort();
}

}  // namespace
}  // namespace saccade

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace saccade;
  if (size == 0) return 0;
  const std::span<const std::byte> message(reinterpret_cast<const std::byte*>(data + 1), size - 1);
  const std::size_t parser = data[0] % 5;
  if (parser < 3) {
    EventPacket packet;
    (void)read_packet(message, static_cast<PacketFormat>(parser), packet);
    require(4 * packet.events.size() <= message.size());
  } else if (parser == 3) {
    std::array<double, 12> values{};
    int count = 0;
    if (read_number_list(message, values, count).empty())
      require(count >= 0 && static_cast<std::size_t>(count) <= message.size());
  } else {
    (void)check_bottle(message);
  }
  return 0;
}
