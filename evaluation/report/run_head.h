#pragma once

#include <string>

#include "evaluation/report/run_data.h"

namespace saccade {

/// The top of a run's report, as HTML: its description, the headline figures in words, and what made it (scenario, version,
/// commit, seed, settings, camera, events with those dropped).
[[nodiscard]] std::string run_head(const RunData& run);

}  // namespace saccade
