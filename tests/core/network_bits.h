#pragma once

#include <cstdint>
#include <vector>

namespace saccade {

/// The results of the networks of `best` with the built-in weights on streams made here, bit by bit: of DiscNetwork, of polar
/// patches, of PatchNetwork and of the probability. tests/core/CMakeLists.txt compiles it a second time without vector
/// clones, in the namespace saccade_without_clones.
[[nodiscard]] std::vector<std::uint64_t> network_bits();

}  // namespace saccade
