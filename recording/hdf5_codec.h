#pragma once

#include "recording/event_file.h"

namespace saccade {

/// HDF5 in two layouts:
///   DSEC  a group /events with x, y, t (us) and p (0 or 1, or -1 or 1; 1 = ON), each a number per event, and, where
///         there are, scalars width and height; /t_offset, a scalar that is added to t. /ms_to_idx is not needed.
///   v2e   a table /events of N x 4: t (us), x, y, p.
/// Whole numbers of any width; times of 32 bits are continued when they wrap. Any compression that libhdf5 has a filter
/// for: gzip always; Blosc, as in DSEC's own files, with its plugin, and without it an InputError that says so.
///
/// libhdf5 does not survive every broken file: it reads in a child process, and where it crashes, or finds no end,
/// that is an InputError of this file. A file that is cut off is refused by libhdf5 as a whole. `path` has to be a
/// file, no pipe.
[[nodiscard]] std::unique_ptr<EventReader> open_hdf5(const std::filesystem::path& path,
                                                     const EventReadOptions& options);

/// Writes DSEC's layout with gzip: x, y 16 bits, t 32, p 8, /t_offset the first event's time; /ms_to_idx[ms] is the
/// first event at or after ms, and its last entry is that behind the last event, so that every window of whole
/// milliseconds up to there can be cut out. Throws InputError for two cameras, for time that goes back, and for
/// recordings of more than 2^32 us.
[[nodiscard]] std::unique_ptr<EventWriter> create_hdf5(const std::filesystem::path& path,
                                                       ImageSize image_size, int cameras);

}  // namespace saccade
