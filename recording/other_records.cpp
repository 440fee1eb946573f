#include "recording/other_records.h"

namespace saccade {

std::string_view text_of(TriggerKind kind) {
  constexpr std::array<std::string_view, 11> texts = {
      "unknown", "falling",     "rising",    "pulse",          "generator_rising", "generator_falling",
      "reset",   "frame_begin", "frame_end", "exposure_begin", "exposure_end"};
  return texts[static_cast<std::size_t>(kind)];
}

}  // namespace saccade
