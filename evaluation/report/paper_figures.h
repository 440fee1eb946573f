#pragma once

#include <filesystem>

#include "evaluation/report/gnuplot.h"

namespace saccade {

/// Draws a figure for a paper: NAME.svg, NAME.pdf and NAME.csv in `folder`. One panel has the width of one column, several
/// panels that of the page of a two-column paper (IEEE: 88 and 181 mm); the font is a serif of 8 and 7 pt. Throws RunError.
void write_paper_figure(const Figure& figure, const std::filesystem::path& folder);

}  // namespace saccade
