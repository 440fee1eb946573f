#include "robot/yarp/checked_message.h"

#include <vector>

#include "robot/bottle.h"
#include "robot/yarp/yarp_network.h"

namespace saccade::inline v0_1 {

std::optional<yarp::os::Bottle> checked_message(yarp::os::ConnectionReader& reader) {
  if (!reader.isValid()) return std::nullopt;
  yarp::os::Bottle message;
  if (reader.isTextMode()) {
    const std::string line = reader.expectText();
    if (line.size() > longest_bottle) {
      reader.requestDrop();
      return std::nullopt;
    }
    message.fromString(line);
    return message;
  }
  const std::size_t size = reader.getSize();
  if (size > longest_bottle) {
    discard(reader);
    return std::nullopt;
  }
  std::vector<std::byte> bytes(size);
  if (!reader.expectBlock(reinterpret_cast<char*>(bytes.data()), size)) return std::nullopt;
  if (!check_bottle(bytes).empty()) {
    reader.requestDrop();
    return std::nullopt;
  }
  message.fromBinary(reinterpret_cast<const char*>(bytes.data()), size);
  return message;
}

}  // namespace saccade::inline v0_1
