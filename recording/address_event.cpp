#include "recording/address_event.h"

#include <algorithm>
#include <array>

#include "core/error.h"

namespace saccade {
namespace {

struct Bits {
  int shift;
  int count;

  [[nodiscard]] std::uint32_t mask() const { return (1U << count) - 1; }
  [[nodiscard]] std::uint32_t of(std::uint32_t word) const { return word >> shift & mask(); }
};

struct Layout {
  Bits x;
  Bits y;
  Bits channel;
  Bits skin;  // no bits where the codec has no skin
  std::int64_t tick_ns;
};

constexpr std::array<Layout, 4> layouts = {{
    {{1, 7}, {8, 7}, {15, 1}, {0, 0}, 128},
    {{1, 9}, {10, 8}, {20, 1}, {21, 1}, 80},
    {{1, 10}, {12, 9}, {22, 1}, {24, 1}, 80},
    {{1, 11}, {12, 10}, {22, 1}, {24, 1}, 80},
}};

const Layout& layout_of(AddressCodec codec) { return layouts[static_cast<std::size_t>(codec)]; }

}  // namespace

const std::vector<std::string>& address_codec_names() {
  static const std::vector<std::string> names = {"dvs_128", "atis_20", "atis_24", "ev2"};
  return names;
}

std::optional<AddressCodec> address_codec(std::string_view name) {
  const auto& names = address_codec_names();
  const auto it = std::find(names.begin(), names.end(), name);
  if (it == names.end()) return std::nullopt;
  return static_cast<AddressCodec>(it - names.begin());
}

std::int64_t tick_ns(AddressCodec codec) { return layout_of(codec).tick_ns; }

std::optional<Event> decode_address(std::uint32_t word, AddressCodec codec) {
  const Layout& layout = layout_of(codec);
  if (layout.skin.of(word) != 0) return std::nullopt;
  Event event;
  event.on = (word & 1) == 0;
  event.x = static_cast<std::uint16_t>(layout.x.of(word));
  event.y = static_cast<std::uint16_t>(layout.y.of(word));
  event.camera = static_cast<std::uint8_t>(layout.channel.of(word));
  return event;
}

std::uint32_t encode_address(const Event& event, AddressCodec codec) {
  const Layout& layout = layout_of(codec);
  SACCADE_CHECK(event.x <= layout.x.mask() && event.y <= layout.y.mask() && event.camera <= 1);
  return (event.on ? 0U : 1U) | std::uint32_t{event.x} << layout.x.shift |
         std::uint32_t{event.y} << layout.y.shift | std::uint32_t{event.camera} << layout.channel.shift;
}

bool is_encodable(ImageSize size, AddressCodec codec) {
  const Layout& layout = layout_of(codec);
  return size.width <= static_cast<int>(layout.x.mask()) + 1 &&
         size.height <= static_cast<int>(layout.y.mask()) + 1;
}

}  // namespace saccade
