#include "apps/cli/read_options.h"

#include <charconv>
#include <map>

#include "core/error.h"

namespace saccade {
namespace {

/// "640x480"
ImageSize parse_size(const std::string& text) {
  ImageSize size;
  const char* const end = text.data() + text.size();
  const auto width = std::from_chars(text.data(), end, size.width);
  if (width.ec == std::errc() && width.ptr != end && *width.ptr == 'x') {
    const auto height = std::from_chars(width.ptr + 1, end, size.height);
    const bool in_range = size.width >= 8 && size.height >= 8 && size.width <= 2048 && size.height <= 2048;
    if (height.ec == std::errc() && height.ptr == end && in_range) return size;
  }
  throw InputError("--size", text, "WIDTHxHEIGHT, each 8 to 2048, such as 128x128");
}

}  // namespace

Option add_read_options(Command& command, const char* name, const char* meaning, ReadOptions& options,
                        const FormatRegistry& formats) {
  const Option recording = command.option(name, options.recording, meaning).required();
  add_decoding_options(command, options, formats);
  return recording;
}

void add_decoding_options(Command& command, ReadOptions& options, const FormatRegistry& formats) {
  options.formats = formats;
  command.option(
      "--size", [&options](const std::string& text) { options.read.image_size = parse_size(text); },
      "Image size WIDTHxHEIGHT, where the file has none");
  command
      .option("--columns", options.read.columns,
              "Order of the columns of a text, an array or a table, out of t, x, y, p, c for the camera and "
              "_ for one "
              "that is not read; auto: that of the file's names, else txyp")
      .show_default();
  command
      .option(
          "--time-unit", [&options](const std::string& word) { options.read.time_unit = time_unit_of(word); },
          "Unit of the times in text, NumPy's arrays and HDF5: s, ms, us or ns; by default the file's own, "
          "else us, "
          "and s for numbers with a decimal point")
      .one_of({"s", "ms", "us", "ns"});
  const std::map<std::string, std::uint8_t> cameras = {{"left", 0}, {"right", 1}};
  command
      .option(
          "--camera", [&options, cameras](const std::string& eye) { options.read.camera = cameras.at(eye); },
          "Of a recording of two cameras: left or right alone")
      .one_of({"left", "right"});
  command
      .option(
          "--codec", options.read.yarp_codec,
          "Layout of an event-driven log's words: dvs_128, dvs_128_upright, atis_20, atis_24, ev2 or ev2_ts; "
          "auto: that of its info file, else guessed")
      .show_default()
      .offers([]() -> std::vector<std::string> {
        return {"auto", "dvs_128", "dvs_128_upright", "atis_20", "atis_24", "ev2", "ev2_ts"};
      });
  command
      .option("--layout", options.read.aedat2_layout,
              "Layout of an AEDAT 2.0 file's addresses: dvs128, stereo, dvs640 or davis; auto: that of its "
              "header, else "
              "guessed")
      .show_default()
      .one_of({"auto", "dvs128", "stereo", "dvs640", "davis"});
  command
      .option("--evt", options.read.evt_encoding,
              "Encoding of a Prophesee RAW file: evt2, evt21, evt21_legacy (upper half of each word first) "
              "or evt3; "
              "auto: that of its header, else guessed")
      .show_default()
      .one_of({"auto", "evt2", "evt21", "evt21_legacy", "evt3"});
  command
      .option("--es-y", options.read.event_stream_y,
              "Direction of y in an Event Stream file: up, as the format defines, or down, of programs that "
              "store rows "
              "from the top")
      .show_default()
      .one_of({"up", "down"});
  command
      .option("--format", options.read.format,
              "Format of the recording, a name of the table in docs/recordings.md such as N-MNIST; auto: by "
              "its content")
      .show_default();
}

}  // namespace saccade
