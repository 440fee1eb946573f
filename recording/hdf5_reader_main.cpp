// saccade-hdf5-reader PATH SIZE COLUMNS UNIT: reads an HDF5 recording in a process of its own and writes its events to standard
// output as recording/helper_protocol.h describes. The others are EventReadOptions: WIDTHxHEIGHT where the file has no size,
// the order of a table's columns, the unit of the times; each may be empty. saccade-hdf5-reader PATH ARRAY: the same with an array
// of ground truth.
#include <unistd.h>

#include <cstdio>

#include "recording/codec.h"
#include "recording/hdf5_array.h"
#include "recording/hdf5_reader.h"
#include "recording/helper_server.h"

int main(int argc, char** argv) {
  using namespace saccade;
  if ((argc != 3 && argc != 5) || ::isatty(STDOUT_FILENO) != 0) {
    std::fputs("saccade starts this program to read HDF5 files; it has no use of its own\n", stderr);
    return 2;
  }
  if (argc == 3) serve_array(STDOUT_FILENO, [&] { return open_hdf5_array_here(argv[1], argv[2]); });
  EventReadOptions options;
  options.image_size = parse_size(argv[2]);
  if (*argv[3] != '\0') options.columns = argv[3];
  options.time_unit = time_unit_of(argv[4]);
  serve_events(STDOUT_FILENO, [&] { return open_hdf5_here(argv[1], options); });
}
