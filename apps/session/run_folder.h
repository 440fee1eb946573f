#pragma once

#include <filesystem>
#include <string>

#include "evaluation/scoring/metrics.h"

namespace saccade::inline v0_1 {

class FormatRegistry;

/// Creates the folder of a run. A folder that is not empty is rejected without `force`; with it, the files of an earlier
/// run are removed (event files of `formats`), nothing else is, and a folder without a run is rejected. Throws InputError, RunError.
void prepare_run_folder(const std::filesystem::path& folder, bool force, const FormatRegistry& formats);
/// The same, and writes the run's resolved configuration into the file `name`.
void start_run_folder(const std::filesystem::path& folder, bool force, const FormatRegistry& formats,
                      const std::string& name, const std::string& text);
/// Throws RunError with the reasons if detectors ended before the end of the run (DetectorScore::failure).
void throw_if_a_program_ended(const Metrics& metrics);
/// Writes the report of a folder with metrics.json, prints the summary and the report's path. Throws RunError if the run
/// was interrupted() or a detector ended before its end; the folder is complete then.
void finish_run_folder(const std::filesystem::path& folder, const Metrics& metrics,
                       const FormatRegistry& formats);

}  // namespace saccade::inline v0_1
