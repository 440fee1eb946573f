#pragma once

#include "recording/format_registry.h"

namespace saccade::inline v0_1 {

/// Text: one event per line, four fields separated by white space or a comma: time, x, y, polarity, or another order
/// given by EventReadOptions::columns. A fifth field is the camera, 0 left and 1 right, where `columns` has c or the line
/// of column names ends with a name that begins with c. Time is in seconds when it has a decimal point (rounded to the
/// nearest us), else in us; a file uses one of them throughout. Polarity is 0 or 1, or -1 or 1. Empty lines, lines that
/// start with # and one line of column names before the first event are skipped; column names in another order than
/// `columns` are an InputError.
///
/// The writer makes `t_us,x,y,p` with that header, `t_us,x,y,p,camera` of two cameras.
[[nodiscard]] RecordingFormat text_format();

}  // namespace saccade::inline v0_1
