#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "apps/commands.h"
#include "apps/read_options.h"

namespace saccade {
namespace {

int info(const ReadOptions& options) {
  const auto reader = open_event_file(options.recording, options.read);
  std::vector<Event> block;
  std::int64_t count = 0, right = 0, on = 0, back_in_time = 0, longest_gap_us = 0;
  Event first, last;
  int width = 0, height = 0;
  for (block.reserve(1 << 16); reader->read(block, 1 << 16) > 0; block.clear()) {
    for (const Event& event : block) {
      if (count == 0) first = last = event;
      on += event.on ? 1 : 0;
      right += event.camera == 1 ? 1 : 0;
      back_in_time += event.t_us < last.t_us ? 1 : 0;
      longest_gap_us = std::max(longest_gap_us, event.t_us - last.t_us);
      width = std::max(width, event.x + 1);
      height = std::max(height, event.y + 1);
      last = event;
      ++count;
    }
  }
  const std::optional<ImageSize> size = reader->image_size();
  const double duration_s = static_cast<double>(last.t_us - first.t_us) * 1e-6;
  fmt::print("format         {}\n", reader->format());
  fmt::print("image          {}\n", size ? fmt::format("{} x {}", size->width, size->height)
                                         : fmt::format("not told; events reach {} x {}", width, height));
  fmt::print("events         {}\n", count);
  if (right > 0) fmt::print("left : right   {} : {}\n", count - right, right);
  if (!reader->passed_over().empty()) fmt::print("passed over    {}\n", reader->passed_over());
  if (count == 0) return 0;
  fmt::print("time           {} us to {} us, {:.6f} s\n", first.t_us, last.t_us, duration_s);
  if (duration_s > 0.0)
    fmt::print("rate           {:.0f} events/s\n", static_cast<double>(count) / duration_s);
  fmt::print("ON : OFF       {} : {}\n", on, count - on);
  fmt::print("longest gap    {} us\n", longest_gap_us);
  fmt::print("back in time   {}\n", back_in_time);
  return 0;
}

}  // namespace

void add_info_command(CLI::App& app, Action& action) {
  auto options = std::make_shared<ReadOptions>();
  CLI::App* command = app.add_subcommand("info", "What a recording holds");
  add_read_options(*command, "recording", "Event file", *options);
  command->callback([options, &action] { action = [options] { return info(*options); }; });
}

}  // namespace saccade
