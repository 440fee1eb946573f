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

/// The image size of a file that does not tell it: what its events reach.
ImageSize reached_size(const ConvertOptions& options) {
  const auto reader = open_event_file(options.recording, options.read);
  if (const auto size = reader->image_size()) return *size;
  std::vector<Event> block;
  ImageSize size{1, 1};
  for (; reader->read(block, 1 << 16) > 0; block.clear()) {
    for (const Event& event : block) {
      size = {std::max(size.width, event.x + 1), std::max(size.height, event.y + 1)};
    }
  }
  return size;
}

int convert(const ConvertOptions& options) {
  const auto writer = create_event_file(options.out, reached_size(options));
  const auto reader = open_event_file(options.recording, options.read);
  std::vector<Event> block;
  std::int64_t count = 0;
  for (; reader->read(block, 1 << 16) > 0; block.clear()) {
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
