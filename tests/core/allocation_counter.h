#pragma once

#include <cstdint>

namespace saccade {

/// How often this program has called operator new so far, in any thread. Linking allocation_counter.cpp
/// replaces the operator.
[[nodiscard]] std::int64_t allocation_count();

}  // namespace saccade
