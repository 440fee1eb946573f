#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/event.h"
#include "recording/event_columns.h"
#include "recording/event_file.h"
#include "recording/hdf5_handle.h"

namespace saccade {

/// A column of events in an HDF5 file: a dataset of its own, a member of a dataset's records, or a column of a table.
struct Hdf5Column {
  EventColumn column{};
  std::string dataset;           ///< "/events/t"
  std::string member;            ///< of records; empty: the dataset has numbers
  std::optional<hsize_t> place;  ///< in the rows of a table
  std::optional<TimeUnit> unit;  ///< of a time, where the file says it
};

/// Where the events of a camera lie in an HDF5 file.
struct Hdf5Layout {
  std::string name;  ///< "layout of DSEC", "events of /davis/left/events"
  std::string path;  ///< of the group or the dataset
  std::vector<Hdf5Column> columns;
  std::string offset;  ///< dataset of a number that is added to the times; empty: none
  std::optional<ImageSize> image_size;
};

/// Finds the events in a file: records or datasets of one group with the names of event_column(), or a table whose name is
/// `events`. One camera, or a left and a right one, which their paths name. The order of a table's columns is that of
/// EventReadOptions::columns, else as v2e (`/events`) or MVSEC (below `/davis`) write it. Throws InputError, with what the file
/// has, where there are no events, or several that are not a left and a right camera's. `name`: of the file.
[[nodiscard]] std::vector<Hdf5Layout> hdf5_layouts(hid_t file, const std::string& name,
                                                   const EventReadOptions& options);

}  // namespace saccade
