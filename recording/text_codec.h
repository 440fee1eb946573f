#pragma once

#include "recording/format_registry.h"

namespace saccade {

/// Text: one event per line, fields separated by white space, a comma or a semicolon: time, x, y, polarity and where there
/// are two the camera, 0 left and 1 right. Their order is that of EventReadOptions::columns, else that of a line of names
/// before the first event (or of a comment of such names), else xypt behind a comment `%geometry:WIDTH,HEIGHT` as Prophesee's
/// programs write it, else txyp. Further columns are not read and listed by skipped(). Names that contradict the option, or
/// leave the order open, are an InputError.
///
/// The unit of the time is that of EventReadOptions::time_unit, else that of its column's name, else s where the times have a
/// decimal point and us where not, for the whole file; without a unit, times beyond 4e15 us of 0 and those of
/// why_not_seconds() are an InputError. Polarity is 0 or 1, -1 or 1, or False or True.
///
/// A byte order mark, empty lines, lines that start with # or % and one line of the image size, "240 180", are skipped; the
/// latter and a comment with `geometry` give the image size. A ZIP file with one text in it is read like that text.
///
/// The writer makes `t_us,x,y,p` with that header, `t_us,x,y,p,camera` of two cameras.
[[nodiscard]] RecordingFormat text_format();

}  // namespace saccade
