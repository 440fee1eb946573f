#pragma once

#include "recording/format_registry.h"

namespace saccade {

/// HDF5 in the layouts that recording/hdf5_layout.h finds:
///   datasets  t, x, y and p (0 or 1, or -1 or 1; 1 = ON) in a group, each a number per event: DSEC's /events, with optional
///             scalars width and height and /t_offset, which is added to t (/ms_to_idx is not needed); M3ED's
///             /prophesee/left and right; event_utils' /events/{ts,xs,ys,ps}; e2calib's, in the root
///   records   with these members: Metavision's /CD/events
///   tables    of N x 4: v2e's /events, t (us), x, y, p; MVSEC's /davis/left/events and right, x, y, t (s), p
/// Whole or floating-point numbers, and NumPy's bool; whole times of 32 bits are continued when they wrap. Units as in
/// recording/npz_codec.h. Any compression that libhdf5 has a filter for: gzip always; Blosc, as in DSEC's own files, with its
/// plugin, and without it an InputError that names the plugin.
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

}  // namespace saccade
