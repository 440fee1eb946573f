#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "recording/input_file.h"
#include "recording/yarp_codec.h"

namespace saccade {

/// The packets of an event-driven log one after the other (recording/yarp_log_codec.h).
class YarpPacketSource {
 public:
  virtual ~YarpPacketSource() = default;
  /// The next packet of camera events; false at the end. Throws InputError where the content is broken, at each further
  /// call too; complete words of a list before that place have been returned as a packet by then.
  virtual bool next(YarpPacket& packet) = 0;
  [[nodiscard]] virtual std::int64_t others() const = 0;  ///< lists and packets that were no camera events
  [[nodiscard]] virtual std::string name() const = 0;     ///< of the file
  /// First byte of the newest packet's line, in a binary dump of what is read next.
  [[nodiscard]] virtual std::uint64_t packet_begin() const = 0;
};

/// A log in text form, versions 1 and 2.
[[nodiscard]] std::unique_ptr<YarpPacketSource> yarp_text_packets(InputFile file);
/// A binary dump.
[[nodiscard]] std::unique_ptr<YarpPacketSource> yarp_binary_packets(InputFile file);

/// Whether a file that starts like this is a log in text form.
[[nodiscard]] bool looks_like_yarp_log(std::string_view start);

/// The host's clock ends in 2096, s: ns of that fit into 64 bits.
inline constexpr double yarp_latest_s = 4e9;

}  // namespace saccade
