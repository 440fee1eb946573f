#pragma once

#include <filesystem>

#include "apps/sweep/run_comparison.h"

namespace saccade {

/// Writes a page of all figures of a comparison, those that have changed first, to sort and to filter. Throws RunError.
void write_comparison_page(const RunComparison& comparison, const std::filesystem::path& file);

}  // namespace saccade
