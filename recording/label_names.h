#pragma once

#include <array>
#include <string_view>

namespace saccade {

/// Words of the column `cause` in label tables (labels.csv), in the order of the emulator's EventCause.
inline constexpr std::array<std::string_view, 4> event_cause_names = {"signal", "leak", "shot", "hot"};

}  // namespace saccade
