#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>

#include "apps/commands.h"
#include "apps/read_options.h"

namespace saccade {
namespace {

struct ConvertOptions : ReadOptions {
  std::filesystem::path out;
};

/// What has to be known of a recording before it is written: the size of its images, by its events where it does not
/// tell it, and how many cameras made it.
struct Extent {
  ImageSize size{1, 1};
  int cameras = 1;
};

Extent extent_of(const ConvertOptions& options) {
  const auto reader = open_event_file(options.recording, options.read);
  std::vector<Event> block;
  Extent extent;
  for (; reader->read(block, 1 << 16) > 0; block.clear()) {
    for (const Event& event : block) {
      extent.size = {std::max(extent.size.width, event.x + 1), std::max(extent.size.height, event.y + 1)};
      extent.cameras = std::max(extent.cameras, event.camera + 1);
    }
  }
  extent.size = reader->image_size().value_or(extent.size);
  return extent;
}

/// One camera's events become those of a recording of one camera.
int convert(const ConvertOptions& options) {
  const Extent extent = options.read.camera ? Extent{extent_of(options).size, 1} : extent_of(options);
  const auto writer = create_event_file(options.out, extent.size, extent.cameras);
  const auto reader = open_event_file(options.recording, options.read);
  std::vector<Event> block;
  std::int64_t count = 0;
  for (; reader->read(block, 1 << 16) > 0; block.clear()) {
    if (options.read.camera) {
      for (Event& event : block) event.camera = 0;
    }
    writer->write(block);
    count += static_cast<std::int64_t>(block.size());
  }
  writer->commit();
  fmt::print("{}: {} events\n", options.out.string(), count);
  return 0;
}

}  // namespace

void add_convert_command(CLI::App& app, Action& action) {
  auto options = std::make_shared<ConvertOptions>();
  CLI::App* command =
      app.add_subcommand("convert", "Copy a recording into another format (.aedat, .csv, .txt)");
  add_read_options(*command, "in", "Event file", *options);
  command->add_option("out", options->out, "Event file to write")->required();
  command->callback([options, &action] { action = [options] { return convert(*options); }; });
}

}  // namespace saccade
