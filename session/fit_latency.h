#pragma once

#include "config/scenario.h"
#include "loop/latency.h"

namespace saccade {

/// Runs a scenario without latency and without a folder, and fits the processing times of its detectors, of its frame
/// camera and of its controller on this machine. Throws InputError for a scenario without detectors, RunError after
/// an interrupt.
[[nodiscard]] LatencyConfig fit_latency(Scenario scenario);

}  // namespace saccade
