#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>

#include "apps/cli/commands.h"
#include "apps/cli/read_options.h"
#include "apps/cli/recorded_text.h"
#include "core/error.h"
#include "recording/conversion.h"
#include "recording/format_registry.h"
#include "recording/number_text.h"
#include "recording/output_file.h"
#include "session/interrupt.h"
#include "session/other_records_files.h"
#include "session/progress.h"

namespace saccade {
namespace {

struct ConvertOptions : ReadOptions {
  std::filesystem::path out;
  ConversionConfig conversion;
  std::string polarity = "both";
  std::string rotate;
  std::string filter;
  std::string also;
  bool force = false;
};

/// Adds a clockwise turn before the flips.
void rotate(const std::string& degrees, ConversionConfig& config) {
  if (degrees != "180") config.swap_xy = true;
  if (degrees != "270") config.flip_x = !config.flip_x;
  if (degrees != "90") config.flip_y = !config.flip_y;
}

int convert(const ConvertOptions& options, const FormatRegistry& formats) {
  const std::filesystem::path recording = formats.file_of(events_of(options));
  check_outputs(formats.files_of(options.out), formats.inputs_of(recording), options.force);
  ConversionConfig config = options.conversion;
  config.read = options.read;
  config.remove_outside = !options.read.image_size;
  if (options.polarity != "both") config.only_on = options.polarity == "on";
  if (!options.rotate.empty()) rotate(options.rotate, config);
  for (std::string_view rest = options.filter; !rest.empty();) {
    const std::string_view word = rest.substr(0, rest.find(','));
    rest.remove_prefix(std::min(rest.size(), word.size() + 1));
    if (word == "hot") {
      config.remove_hot = true;
    } else if (word == "background") {
      config.remove_background = true;
    } else {
      throw InputError("--filter", options.filter, "hot, background, or hot,background");
    }
  }
  std::optional<OtherRecordsFiles> others;
  if (!options.also.empty()) config.read.others = &others.emplace(options.out, options.also, options.force);
  catch_interrupts();
  std::array<Progress, 2> progress = {Progress(0.0), Progress(0.0)};
  const auto show = [&](bool second_pass, std::int64_t events) {
    if (interrupted()) throw RunError("interrupted; nothing was written");
    const double millions = 1e-6 * static_cast<double>(events);
    if (millions < 10.0) return;  // less than a second
    progress[second_pass ? 1 : 0].show(millions * 100.0, [&] {
      return fmt::format("{} {:.0f} million events", second_pass ? "converted" : "read", millions);
    });
  };
  const ConversionResult result = convert_recording(formats, recording, options.out, config, show);
  fmt::print("{}: {} events\n", options.out.string(), result.events);
  if (others)
    for (const std::string& line : others->commit()) fmt::print("{}\n", line);
  const auto removed = [](std::int64_t events, const char* why) {
    if (events > 0) fmt::print("removed: {} {}\n", events, why);
  };
  removed(result.outside_time, "outside the time");
  removed(result.outside_region, "outside the region");
  removed(result.outside_image, "outside the image");
  removed(result.other_polarity, "of the other polarity");
  if (result.hot > 0) fmt::print("removed: {} of {} hot pixels\n", result.hot, result.hot_pixels);
  removed(result.background, "without a neighbour in the 10 ms before");
  removed(result.decimated, "by --decimate");
  if (result.torn) fmt::print("{}: {}\n", result.torn->is_cut ? "torn" : "broken", text_of(*result.torn));
  if (!result.skipped.empty()) fmt::print("skipped: {}\n", result.skipped);
  if (!result.guess.empty()) fmt::print("guessed: {}\n", result.guess);
  return 0;
}

/// "10,20,64,48"
PixelRegion parse_region(const std::string& text) {
  std::array<int, 4> numbers{};
  std::string_view rest = text;
  bool ok = true;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const std::size_t comma = std::min(rest.find(','), rest.size());
    ok = ok && parse_number(rest.substr(0, comma), numbers[i]) && (i == 3) == (comma == rest.size());
    rest.remove_prefix(std::min(comma + 1, rest.size()));
  }
  const PixelRegion region{numbers[0], numbers[1], numbers[2], numbers[3]};
  const bool inside = region.x >= 0 && region.y >= 0 && region.width >= 1 && region.height >= 1 &&
                      region.x <= 65535 && region.y <= 65535 && region.width <= 65536 &&
                      region.height <= 65536;
  if (!ok || !inside) throw InputError("--region", text, "X,Y,WIDTH,HEIGHT in pixels, such as 10,20,64,48");
  return region;
}

}  // namespace

void add_convert_command(CommandLine& line, const Registry& registry) {
  auto options = std::make_shared<ConvertOptions>();
  Command command = line.add_command("convert", "Copy a recording into another format, or a part of it");
  add_read_options(command, "in", "Event file, a folder with data.log, or a run folder", *options,
                   registry.formats);
  ConversionConfig& config = options->conversion;
  const FormatRegistry& formats = registry.formats;
  command
      .option("out", options->out,
              "Event file to write; the extension selects the format: " + formats.written_extensions())
      .required();
  command.flag("--force", options->force, "Replace files that exist");
  command.option("--from", config.from_s, "Remove events before this time, s after the first event")
      .in_range(0.0, 1e9);
  command.option("--until", config.until_s, "Remove events at this time and later, s after the first event")
      .in_range(0.0, 1e9);
  command.flag("--zero-time", config.zero_time, "The first event written is at 0 us");
  command.option(
      "--region", [&config](const std::string& text) { config.region = parse_region(text); },
      "X,Y,WIDTH,HEIGHT: remove events outside, px of the recording");
  command.flag("--crop", config.crop, "The region becomes the image, its corner pixel 0, 0");
  command.option("--polarity", options->polarity, "Only on or off events")
      .one_of({"both", "on", "off"})
      .show_default();
  command.option("--filter", options->filter,
                 "hot: remove pixels with 100 events or more and over 10 times the mean of their neighbours; "
                 "background: "
                 "remove events without one of a neighbouring pixel in the 10 ms before; or hot,background");
  command.option(
      "--also", options->also,
      "frames,imu,triggers or some of them: write what the recording holds besides events into OUT.frames/, "
      "OUT.imu.csv and OUT.triggers.csv, OUT without its extension; AEDAT 2 and 4, RAW, bags, MCAP");
  command.option("--decimate", config.decimate,
                 "Of the events of each pixel and polarity keep every N-th, from the first on");
  command.flag("--invert", config.invert, "ON becomes OFF and OFF becomes ON");
  Option swap = command.flag("--swap-xy", config.swap_xy, "Exchange x and y, after --region");
  command.option("--rotate", options->rotate, "Turn clockwise by so many degrees, after --region")
      .one_of({"90", "180", "270"})
      .excludes(swap);
  command.flag("--flip-x", config.flip_x, "Mirror left and right, after --swap-xy and --rotate");
  command.flag("--whole-part", config.whole_part,
               "Of a torn recording: the events before the place where it breaks off");
  command.flag("--flip-y", config.flip_y, "Mirror top and bottom, after --swap-xy and --rotate");
  command.footer(
      "Events of the right camera need a format of two cameras (" + formats.written_extensions(2) +
      "), or --camera.\n"
      "The recording is read twice. Events outside the image whose size it states are removed and counted; "
      "with --size "
      "they are an error. What else the format cannot hold is an error, and nothing is written.");
  command.action([options, &formats] { return convert(*options, formats); });
}

}  // namespace saccade
