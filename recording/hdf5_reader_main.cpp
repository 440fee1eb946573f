// saccade-hdf5-reader PATH [WIDTHxHEIGHT]: reads an HDF5 recording in a process of its own and writes its events to standard
// output as recording/helper_protocol.h describes. The size is used where the file has none.
#include <unistd.h>

#include <cstdio>

#include "recording/codec.h"
#include "recording/hdf5_reader.h"
#include "recording/helper_server.h"

int main(int argc, char** argv) {
  using namespace saccade;
  if (argc < 2 || argc > 3 || ::isatty(STDOUT_FILENO) != 0) {
    std::fputs("saccade starts this program to read HDF5 files; it has no use of its own\n", stderr);
    return 2;
  }
  EventReadOptions options;
  if (argc == 3) options.image_size = parse_size(argv[2]);
  serve_events(STDOUT_FILENO, [&] { return open_hdf5_here(argv[1], options); });
}
