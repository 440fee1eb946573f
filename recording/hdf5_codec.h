#pragma once

#include "recording/format_registry.h"

namespace saccade::inline v0_1 {

/// HDF5 in two layouts:
///   DSEC  a group /events with x, y, t (us) and p (0 or 1, or -1 or 1; 1 = ON), each a number per event, and optional
///         scalars width and height; /t_offset, a scalar that is added to t. /ms_to_idx is not needed.
///   v2e   a table /events of N x 4: t (us), x, y, p.
/// Whole numbers of any width; times of 32 bits are continued when they wrap. Any compression that libhdf5 has a filter
/// for: gzip always; Blosc, as in DSEC's own files, with its plugin, and without it an InputError that names the plugin.
///
/// libhdf5 crashes on some broken files. It therefore reads in a helper process (recording/helper_reader.h): a crash, or a
/// read that does not end, is an InputError of this file. libhdf5 rejects a truncated file as a whole. `path` must be a
/// file, no pipe.
///
/// The writer makes DSEC's layout with gzip: x, y 16 bits, t 32, p 8, /t_offset the first event's time; /ms_to_idx[ms] is
/// the first event at or after ms, and its last entry is that after the last event, so that every window of whole
/// milliseconds up to there can be cut out. It throws InputError for time that goes back, and for recordings of more than
/// 2^32 us.
[[nodiscard]] RecordingFormat hdf5_format();

}  // namespace saccade::inline v0_1
