#pragma once

#include "recording/format_registry.h"

namespace saccade {

/// Prophesee's RAW files: lines `% key value` (prophesee_header.h), then little-endian words in the encoding that
/// `% evt 3.0` or `% format EVT3` names, else EventReadOptions::evt_encoding, else the first 64 KiB of words; format() marks
/// the last as guessed. The origin is top left, 1 is ON.
///
/// EVT2, 32 bits from the top: type 4, time 6, x 11, y 11. Types 0 OFF and 1 ON; 8 has the time's upper 28 bits, which
/// wrap at 2^34 us.
/// EVT2.1, 64 bits from the top: type 4, time 6, x 11, y 11, a bit for each of 32 pixels from x on, from the lowest. Types as
/// in EVT2; 8 has the time's upper 28 bits below the type. `;endianness=legacy` in the line `% format` has the upper half of
/// each word first, as IMX636 sends it; without `;endianness=` the words determine the order.
/// EVT3, 16 bits: type 4 and, by type: 0 y (11 bits); 2 an event at x (11) of polarity bit 11; 3 the x (11) and polarity
/// (bit 11) where vectors begin; 4 and 5 vectors, a bit for each of the next 12 or 8 pixels, from the lowest;
/// 6 the lower and 8 the upper 12 bits of the time, which wraps at 2^24 us. The time is upper << 12 | lower: where the
/// lower part falls without a new upper one, the time goes back.
///
/// The reader skips and counts events before the first time, or in EVT3 the first row, triggers, words of other defined
/// types (EVT2: D, E, F; EVT2.1: E, F; EVT3: 7, E, F) and, type by type, words of undefined types. Without a line on geometry
/// the image size is EventReadOptions::image_size; pixels are not checked against it. A line `% time_offset_us N`, which
/// our writer makes, is added to the times.
///
/// The writer makes EVT3, or EVT2 where the file's name ends in `.evt2.raw`, of an image of up to 2048 x 2048. In EVT3 neighbouring pixels of a row at one time become vectors, in
/// the sensor's groups of 12, 12 and 8, where that is shorter. Where the first event is not in the counter's first
/// 16.8 s (EVT2: 4.8 h), the multiple of 2^24 us (2^34) before it goes into the header as `% time_offset_us N`; other readers ignore that line
/// and have times from 0 to 16.8 s (4.8 h) on. Words of time are written during silences. The writer throws InputError for times
/// that would not read back the same: those that go back by more than 4.2 s or before the offset, and silences of more
/// than 19 h.
[[nodiscard]] RecordingFormat prophesee_raw_format();

}  // namespace saccade
