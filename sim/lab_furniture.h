#pragma once

#include <cstdint>

#include "sim/lab.h"
#include "sim/lab_layout.h"

namespace saccade::lab {

/// The room of a lab with its furniture and objects, packed. The same config and seed give the same layout.
[[nodiscard]] Layout furnished(const LabConfig& config, std::uint64_t seed);

}  // namespace saccade::lab
