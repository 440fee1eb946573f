#pragma once

#include "recording/event_file.h"
#include "recording/input_file.h"

namespace saccade {

/// One event per line, four fields apart by whitespace or a comma: time, x, y, polarity, or another order
/// named by EventReadOptions::columns; with a fifth one, the camera, 0 left and 1 right, where `columns` has c or the
/// line of column names has one that begins with c at its end. Time is in seconds when it has a decimal point (rounded to the
/// nearest us), else in us; one file keeps to one of them. Polarity is 0 or 1, or -1 or 1. Empty lines,
/// lines that start with # and one line of column names before the first event are passed over; names
/// that say another order than `columns` are an InputError.
[[nodiscard]] std::unique_ptr<EventReader> open_text(InputFile file, const EventReadOptions& options);

/// Writes `t_us,x,y,p` and that header; of two cameras `t_us,x,y,p,camera`.
[[nodiscard]] std::unique_ptr<EventWriter> create_text(const std::filesystem::path& path,
                                                       ImageSize image_size, int cameras);

}  // namespace saccade
