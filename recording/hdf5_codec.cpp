#include "recording/hdf5_codec.h"

#include "recording/codec.h"
#include "recording/hdf5_library.h"
#include "recording/helper_reader.h"
#include "recording/input_file.h"

namespace saccade {

const Hdf5Library& hdf5_library() {
  return *static_cast<const Hdf5Library*>(helper_symbol("saccade-hdf5-writer.so", "saccade_hdf5_writer_1"));
}

RecordingFormat hdf5_format() {
  RecordingFormat format;
  format.name = "HDF5";
  format.extensions = {".h5", ".hdf5"};
  format.sniff = [](const FileStart& start) {
    return start.bytes.starts_with("\x89HDF\r\n\x1a\n") ? Match::certain : Match::none;
  };
  format.open = [](InputFile file, const EventReadOptions& options) {
    const std::string size = options.image_size ? text_of(*options.image_size) : std::string();
    const std::string unit(options.time_unit ? word_of(*options.time_unit) : "");
    return open_in_helper(file.name(), "libhdf5",
                          {find_helper("saccade-hdf5-reader"), {file.name(), size, options.columns, unit}});
  };
  format.create = [](const std::filesystem::path& path, ImageSize size,
                     int cameras) -> std::unique_ptr<EventWriter> {
    return std::unique_ptr<EventWriter>(hdf5_library().create_events(path, size, cameras));
  };
  format.cameras = 2;
  format.longest_us = std::int64_t{0xffffffff};
  format.read_in_helper = true;
  format.reads =
      "a group of datasets t, x, y, p (DSEC with `/t_offset` and `/events/{width,height,camera}`, M3ED, "
      "event_utils, "
      "e2calib), records of them (Metavision's `/CD/events`), or a table N x 4 `events` (v2e: t, x, y, p; "
      "MVSEC: x, y, t, "
      "p; others by `--columns`); of a left and a right camera both, merged by time; gzip, other filters "
      "with libhdf5's "
      "plugin for them";
  format.writes =
      "DSEC's layout with gzip; `/ms_to_idx` up to the ms after the last event, `/t_offset` the first "
      "event's time; of two cameras `/events/camera`, 0 left and 1 right";
  format.time =
      "in the unit of the name or of `--time-unit`, else whole numbers us, floating-point s; 32 bits "
      "continued over wraps; "
      "written: 32 bits of us after `/t_offset`";
  format.axes = "top left, 1 is ON";
  format.limits = "sorted by time, 2^32 us";
  return format;
}

}  // namespace saccade
