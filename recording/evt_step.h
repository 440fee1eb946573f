#pragma once

#include <cstddef>
#include <optional>

namespace saccade::inline v0_1 {

/// What a decoder of EVT2's or EVT3's words has done in one call.
struct EvtStep {
  std::size_t words = 0;                                ///< decoded
  std::size_t events = 0;                               ///< written
  std::optional<unsigned> unknown_type = std::nullopt;  ///< of the word after them
};

}  // namespace saccade::inline v0_1
