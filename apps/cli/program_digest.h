#pragma once

#include <string>

namespace saccade {

/// Version, commit and a digest of the program itself and the models that it reads.
[[nodiscard]] std::string program_digest();

}  // namespace saccade
