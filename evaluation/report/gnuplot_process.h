#pragma once

#include <string>

namespace saccade {

/// Whether the program gnuplot is in PATH.
[[nodiscard]] bool gnuplot_installed();

/// What gnuplot writes to standard output for a script: an SVG or a PDF, as its `set terminal` says. Throws RunError where
/// gnuplot is missing or fails.
[[nodiscard]] std::string run_gnuplot(const std::string& script);

}  // namespace saccade
