#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <memory>

#include "apps/cli/commands.h"
#include "apps/cli/read_options.h"
#include "apps/session/interrupt.h"
#include "apps/session/progress.h"
#include "core/error.h"
#include "recording/number_text.h"

namespace saccade {
namespace {

constexpr std::size_t block_events = 1 << 16;

struct Region {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;

  [[nodiscard]] bool contains(const Event& e) const {
    return ImageSize{width, height}.contains(e.x - x, e.y - y);
  }
};

struct ConvertOptions : ReadOptions {
  std::filesystem::path out;
  double from_s = -std::numeric_limits<double>::infinity();
  double until_s = std::numeric_limits<double>::infinity();
  std::optional<Region> region;
  bool crop = false;
  std::string polarity = "both";
  bool invert = false;
  bool swap_xy = false;
  bool flip_x = false;
  bool flip_y = false;
  bool zero_time = false;
};

/// What of the events is written, and how they are changed on the way.
class Conversion {
 public:
  /// `image`: of the recording.
  Conversion(const ConvertOptions& options, std::int64_t first_us, ImageSize image)
      : options_(options),
        first_us_(first_us),
        from_us_(at(options.from_s)),
        until_us_(at(options.until_s)),
        image_(options.crop ? ImageSize{options.region->width, options.region->height} : image),
        shift_(options.crop ? *options.region : Region{}) {}

  /// The image of what is written.
  [[nodiscard]] ImageSize image() const {
    return options_.swap_xy ? ImageSize{image_.height, image_.width} : image_;
  }

  /// Takes out what is not wanted and changes the rest; counts what it took out.
  void apply(std::vector<Event>& events) {
    const auto unwanted = [&](const Event& e) {
      if (e.t_us < from_us_ || e.t_us >= until_us_) return count(outside_time);
      if (options_.region && !options_.region->contains(e)) return count(outside_region);
      if (options_.polarity != "both" && e.on != (options_.polarity == "on")) return count(other_polarity);
      return false;
    };
    std::erase_if(events, unwanted);
    for (Event& event : events) change(event);
  }

  std::int64_t outside_time = 0;
  std::int64_t outside_region = 0;
  std::int64_t other_polarity = 0;

 private:
  static bool count(std::int64_t& counter) {
    ++counter;
    return true;
  }
  /// Seconds behind the first event.
  [[nodiscard]] std::int64_t at(double seconds) const {
    constexpr double longest_s = 4e12;
    if (seconds > longest_s) return std::numeric_limits<std::int64_t>::max();
    if (seconds < -longest_s) return std::numeric_limits<std::int64_t>::min();
    return first_us_ + std::llround(seconds * 1e6);
  }

  void change(Event& event) {
    // One camera's events become those of a recording of one camera.
    if (options_.read.camera) event.camera = 0;
    if (options_.invert) event.on = !event.on;
    if (options_.zero_time) {
      if (!zero_us_) zero_us_ = event.t_us;
      event.t_us -= *zero_us_;
    }
    int x = event.x - shift_.x;
    int y = event.y - shift_.y;
    if (options_.swap_xy) std::swap(x, y);
    if (options_.flip_x) x = image().width - 1 - x;
    if (options_.flip_y) y = image().height - 1 - y;
    if (x < 0 || y < 0) {
      throw InputError(
          options_.recording.string(), fmt::format("an event at {}, {}", event.x, event.y),
          fmt::format("pixels inside {} x {}; --region leaves others out", image_.width, image_.height));
    }
    event.x = static_cast<std::uint16_t>(x);
    event.y = static_cast<std::uint16_t>(y);
  }

  const ConvertOptions& options_;
  std::int64_t first_us_;
  std::int64_t from_us_;
  std::int64_t until_us_;
  ImageSize image_;
  Region shift_;
  std::optional<std::int64_t> zero_us_;
};

/// Calls `use(block)` with all of a recording.
template <class Use>
std::unique_ptr<EventReader> for_each_block(const ConvertOptions& options, const char* what, const Use& use) {
  auto reader = open_event_file(events_of(options.recording), options.read);
  Progress progress(0.0);
  std::vector<Event> block;
  double millions = 0.0;
  for (block.reserve(block_events); reader->read(block, block_events) > 0; block.clear()) {
    if (interrupted()) throw RunError("interrupted; nothing was written");
    millions += 1e-6 * static_cast<double>(block.size());
    use(block);
    if (millions < 10.0) continue;  // over in no time
    progress.show(millions * 100.0, [&] { return fmt::format("{} {:.0f} million events", what, millions); });
  }
  return reader;
}

/// What has to be known of a recording before it is written: its first event, the size of its images, by its events
/// where it does not tell it, and how many cameras made it.
struct Extent {
  std::optional<std::int64_t> first_us;
  ImageSize size{1, 1};
  int cameras = 1;
};

Extent extent_of(const ConvertOptions& options) {
  Extent extent;
  const auto reader = for_each_block(options, "looked at", [&](const std::vector<Event>& block) {
    for (const Event& event : block) {
      extent.size = {std::max(extent.size.width, event.x + 1), std::max(extent.size.height, event.y + 1)};
      extent.cameras = std::max(extent.cameras, event.camera + 1);
    }
    if (!extent.first_us) extent.first_us = block.front().t_us;
  });
  extent.size = reader->image_size().value_or(extent.size);
  if (options.read.camera) extent.cameras = 1;
  return extent;
}

void check(const ConvertOptions& options) {
  if (options.crop && !options.region) throw InputError("--crop", "", "--region with it");
  if (!(options.until_s > options.from_s)) {
    throw InputError("--until", fmt::format("{:g}", options.until_s),
                     fmt::format("more than --from, {:g}", options.from_s));
  }
}

int convert(const ConvertOptions& options) {
  check(options);
  catch_interrupts();
  const Extent extent = extent_of(options);
  Conversion conversion(options, extent.first_us.value_or(0), extent.size);
  const auto writer = create_event_file(options.out, conversion.image(), extent.cameras);
  std::int64_t count = 0;
  const auto reader = for_each_block(options, "converted", [&](std::vector<Event>& block) {
    conversion.apply(block);
    writer->write(block);
    count += static_cast<std::int64_t>(block.size());
  });
  writer->commit();
  fmt::print("{}: {} events\n", options.out.string(), count);
  const auto left_out = [](std::int64_t events, const char* why) {
    if (events > 0) fmt::print("left out: {} {}\n", events, why);
  };
  left_out(conversion.outside_time, "outside the time");
  left_out(conversion.outside_region, "outside the region");
  left_out(conversion.other_polarity, "of the other polarity");
  if (!reader->passed_over().empty()) fmt::print("passed over: {}\n", reader->passed_over());
  return 0;
}

/// "10,20,64,48"
Region parse_region(const std::string& text) {
  std::array<int, 4> numbers{};
  std::string_view rest = text;
  bool ok = true;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const std::size_t comma = std::min(rest.find(','), rest.size());
    ok = ok && parse_number(rest.substr(0, comma), numbers[i]) && (i == 3) == (comma == rest.size());
    rest.remove_prefix(std::min(comma + 1, rest.size()));
  }
  const Region region{numbers[0], numbers[1], numbers[2], numbers[3]};
  const bool inside = region.x >= 0 && region.y >= 0 && region.width >= 1 && region.height >= 1 &&
                      region.x <= 65535 && region.y <= 65535 && region.width <= 65536 &&
                      region.height <= 65536;
  if (!ok || !inside) throw InputError("--region", text, "X,Y,WIDTH,HEIGHT in pixels, such as 10,20,64,48");
  return region;
}

}  // namespace

void add_convert_command(CommandLine& line) {
  auto options = std::make_shared<ConvertOptions>();
  Command command = line.add_command("convert", "Copy a recording into another format, or a part of it");
  add_read_options(command, "in", "Event file, a folder with data.log, or a run folder", *options);
  command
      .option("out", options->out,
              "Event file to write; the extension tells the format: " + writable_formats())
      .required();
  command.option("--from", options->from_s, "Leave out what comes before, s after the first event")
      .in_range(0.0, 1e9);
  command.option("--until", options->until_s, "Leave out what comes then or later, s after the first event")
      .in_range(0.0, 1e9);
  command.flag("--zero-time", options->zero_time, "The first event written is at 0 us");
  command.option(
      "--region", [options](const std::string& text) { options->region = parse_region(text); },
      "X,Y,WIDTH,HEIGHT: leave out what is outside, px; in the pixels of the recording");
  command.flag("--crop", options->crop, "The region becomes the image, its corner pixel 0, 0");
  command.option("--polarity", options->polarity, "Only on or off events")
      .one_of({"both", "on", "off"})
      .show_default();
  command.flag("--invert", options->invert, "ON becomes OFF and OFF becomes ON");
  command.flag("--swap-xy", options->swap_xy, "Exchange x and y, behind the region");
  command.flag("--flip-x", options->flip_x, "Mirror left and right, behind --swap-xy");
  command.flag("--flip-y", options->flip_y, "Mirror top and bottom, behind --swap-xy");
  command.footer(
      "--swap-xy --flip-x turns by 90 degrees clockwise, --flip-x --flip-y by 180.\n"
      "Events of the right camera need a format of two cameras (.csv, .txt, .log, of 128 x 128 .aedat), or "
      "--camera.\n"
      "The recording is read twice. What the format cannot hold is an error, and nothing is written.");
  command.action([options] { return convert(*options); });
}

}  // namespace saccade
