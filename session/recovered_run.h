#pragma once

#include <filesystem>

#include "config/registry.h"

namespace saccade {

/// Writes metrics.json, figures.json and report.html into the folder of a run that ended before it wrote them, by a power cut
/// or a signal that cannot be caught, once its event file and tables are whole (write_whole_part()). They hold what follows
/// from scenario.yaml or robot.yaml, the events and the tables: of a simulated run the scores by event time up to the last
/// detection that is in its table. Figures of the gaze, streaming scores and processing times are none. Returns false, and
/// writes nothing, for a folder that has a metrics.json, that is no run's, or in which nothing was recorded. Throws InputError
/// and RunError.
bool complete_run_folder(const std::filesystem::path& folder, const Registry& registry);

}  // namespace saccade
