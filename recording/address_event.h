#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/event.h"

namespace saccade {

/// How pixel, polarity and camera lie in the 32-bit address word of event-driven (IIT), in its logs and on its YARP
/// ports. On this wire polarity is 0 for ON; channel 0 is the left camera.
/// Source: codec_AddressEvent.cpp (v0.9 to v1.7) and core/codec.h (v2.0 on) of robotology/event-driven.
enum class AddressCodec {
  dvs_128,  ///< polarity 0, x 1-7, y 8-14, channel 15: the robots' DVS128 of 2015 and 2016
  atis_20,  ///< polarity 0, x 1-9, y 10-17, type 18-19, channel 20, skin 21
  atis_24,  ///< polarity 0, x 1-10, y 12-20, corner 21, channel 22, type 23, skin 24: v1.1 to v2.1
  ev2,      ///< polarity 0, x 1-11, y 12-21, channel 22, type 23, skin 24, corner 25: after v2.1
};

/// "dvs_128", "atis_20", "atis_24", "ev2", in the order of AddressCodec.
[[nodiscard]] const std::vector<std::string>& address_codec_names();
/// The codec of that name; none where there is no such one.
[[nodiscard]] std::optional<AddressCodec> address_codec(std::string_view name);

/// One tick of the clock that stamps such events: 128 ns with dvs_128, else 80.
[[nodiscard]] std::int64_t tick_ns(AddressCodec codec);
/// Ticks to the nearest us.
[[nodiscard]] inline std::int64_t us_from_ticks(std::int64_t ticks, std::int64_t ns_per_tick) {
  const std::int64_t ns = ticks * ns_per_tick + 500;
  return ns / 1000 - (ns % 1000 < 0 ? 1 : 0);
}
/// Microseconds to the nearest tick, which us_from_ticks takes back to the same microsecond.
[[nodiscard]] inline std::int64_t ticks_from_us(std::int64_t t_us, std::int64_t ns_per_tick) {
  const std::int64_t ns = t_us * 1000 + ns_per_tick / 2;
  return ns / ns_per_tick - (ns % ns_per_tick < 0 ? 1 : 0);
}

/// The event in a word, without its time; nothing where a touch of the skin is in it.
[[nodiscard]] std::optional<Event> decode_address(std::uint32_t word, AddressCodec codec);
/// The word of an event whose x and y fit into it (is_encodable).
[[nodiscard]] std::uint32_t encode_address(const Event& event, AddressCodec codec);
/// Whether x and y of all pixels of such an image fit into a word.
[[nodiscard]] bool is_encodable(ImageSize size, AddressCodec codec);

}  // namespace saccade
