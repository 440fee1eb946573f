#pragma once

#include <filesystem>
#include <string>

#include "evaluation/scoring/metrics.h"

namespace saccade {

/// The key figures of a detector on standard output, in one line.
void print_summary(const std::string& detector, const DetectorScore& score);
/// The key figures of a run on standard output, a line per detector and one for the gaze.
void print_summary(const Metrics& metrics);
/// The path of a folder's page on standard output; on standard error that its figures are not drawn, where that is so.
void print_page(const std::filesystem::path& folder);

}  // namespace saccade
