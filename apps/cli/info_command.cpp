#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "apps/cli/commands.h"
#include "apps/cli/read_options.h"
#include "apps/cli/recorded_text.h"
#include "core/error.h"
#include "recording/format_registry.h"
#include "recording/recording_summary.h"
#include "session/interrupt.h"
#include "session/progress.h"

namespace saccade {
namespace {

using Json = nlohmann::ordered_json;

struct InfoOptions : ReadOptions {
  double gap_ms = 100.0;
  bool json = false;
};

RecordingSummary summarise(const InfoOptions& options, const FormatRegistry& formats) {
  catch_interrupts();
  Progress progress(0.0);
  const auto show = [&](std::int64_t events) {
    if (interrupted()) throw RunError("interrupted");
    const double millions = 1e-6 * static_cast<double>(events);
    if (millions < 10.0) return;  // less than a second
    progress.show(millions * 100.0, [&] { return fmt::format("{:.0f} million events", millions); });
  };
  return summarise_recording(formats, events_of(options), options.read, std::llround(options.gap_ms * 1e3),
                             show);
}

std::string text_of(ImageSize size) { return fmt::format("{} x {}", size.width, size.height); }

std::string rate(std::optional<double> hz) { return hz ? fmt::format("{:.0f}", *hz) : std::string("-"); }

/// The rows of numbers, a column for each stream.
void print_columns(const std::vector<std::pair<const char*, const EventStatistics*>>& columns,
                   double gap_ms) {
  const auto line = [&](const std::string& name, const auto& cell) {
    std::string text = fmt::format("{:<22}", name);
    for (const auto& column : columns) text += fmt::format("{:<24}", cell(column));
    text.erase(text.find_last_not_of(' ') + 1);
    fmt::print("{}\n", text);
  };
  const auto row = [&](const std::string& name, const auto& value) {
    line(name, [&](const auto& column) { return value(*column.second); });
  };
  if (columns.size() > 1) line("", [](const auto& column) { return std::string(column.first); });
  using S = const EventStatistics&;
  row("events", [](S s) { return std::to_string(s.count); });
  row("first event, us", [](S s) { return std::to_string(s.first_us); });
  row("last event, us", [](S s) { return std::to_string(s.newest_us); });
  row("duration, s", [](S s) { return fmt::format("{:.6f}", s.duration_s()); });
  row("mean rate, events/s", [](S s) { return rate(s.mean_rate_hz()); });
  row("peak rate in 100 ms", [](S s) { return fmt::format("{}", s.most_in_100ms * 10); });
  row("peak rate in 1 ms", [](S s) { return fmt::format("{}", s.most_in_1ms * 1000); });
  row("ON : OFF", [](S s) {
    return fmt::format("{} : {} ({:.1f} % ON)", s.on, s.count - s.on,
                       100.0 * static_cast<double>(s.on) / static_cast<double>(s.count));
  });
  row("longest gap, us", [](S s) { return fmt::format("{} at {}", s.longest_gap_us, s.longest_gap_at_us); });
  row(fmt::format("gaps above {:g} ms", gap_ms), [](S s) { return std::to_string(s.gaps); });
  row("back in time", [](S s) {
    return s.back_in_time == 0 ? "0"
                               : fmt::format("{} by up to {} us", s.back_in_time, s.longest_step_back_us);
  });
}

void print_text(const RecordingSummary& info, const InfoOptions& options) {
  const EventStatistics& all = info.counter.all();
  fmt::print("{:<22}{}\n", "file", info.file);
  fmt::print("{:<22}{}\n", "format", info.format);
  fmt::print("{:<22}{}\n", "image", info.image ? text_of(*info.image) : "unknown");
  if (!info.skipped.empty()) fmt::print("{:<22}{}\n", "skipped", info.skipped);
  if (info.torn) fmt::print("{:<22}{}\n", info.torn->is_cut ? "torn" : "broken", text_of(*info.torn));
  if (all.count == 0) {
    fmt::print("{:<22}{}\n", "events", 0);
    return;
  }
  fmt::print("{:<22}{}\n", "events reach", text_of(all.reach));
  if (info.image) fmt::print("{:<22}{}\n", "outside the image", all.outside_image);
  if (info.two_cameras()) {
    print_columns({{"both", &all}, {"left", &info.counter.camera(0)}, {"right", &info.counter.camera(1)}},
                  options.gap_ms);
  } else {
    if (info.counter.camera(1).count > 0) fmt::print("{:<22}{}\n", "camera", "right");
    print_columns({{"", &all}}, options.gap_ms);
  }
}

Json json_of(ImageSize size) { return {{"width", size.width}, {"height", size.height}}; }

Json json_of(const EventStatistics& s) {
  if (s.count == 0) return {{"events", 0}};
  const std::optional<double> mean = s.mean_rate_hz();
  return {{"events", s.count},
          {"first_us", s.first_us},
          {"oldest_us", s.oldest_us},
          {"newest_us", s.newest_us},
          {"duration_s", s.duration_s()},
          {"mean_rate_hz", mean ? Json(*mean) : Json(nullptr)},
          {"peak_rate_hz_in_100ms", s.most_in_100ms * 10},
          {"peak_rate_hz_in_1ms", s.most_in_1ms * 1000},
          {"on", s.on},
          {"off", s.count - s.on},
          {"longest_gap_us", s.longest_gap_us},
          {"longest_gap_at_us", s.longest_gap_at_us},
          {"gaps", s.gaps},
          {"back_in_time", s.back_in_time},
          {"longest_step_back_us", s.longest_step_back_us},
          {"reach", json_of(s.reach)},
          {"outside_image", s.outside_image}};
}

void print_json(const RecordingSummary& info, const InfoOptions& options) {
  Json json = {{"file", info.file},
               {"format", info.format},
               {"image", info.image ? json_of(*info.image) : Json(nullptr)},
               {"skipped", info.skipped},
               {"gap_ms", options.gap_ms}};
  if (info.torn)
    json["torn"] = {{"byte", info.torn->byte},
                    {"bytes", info.torn->bytes},
                    {"cut", info.torn->is_cut},
                    {"cause", info.torn->cause}};
  json.update(json_of(info.counter.all()));
  if (!info.image) json["outside_image"] = nullptr;
  if (info.two_cameras()) {
    json["cameras"] = {{"left", json_of(info.counter.camera(0))}, {"right", json_of(info.counter.camera(1))}};
  }
  fmt::print("{}\n", json.dump(2, ' ', false, Json::error_handler_t::replace));
}

int info_of_folder(const InfoOptions& options, const FormatRegistry& formats) {
  catch_interrupts();
  const auto stop_if_interrupted = [](std::int64_t) {
    if (interrupted()) throw RunError("interrupted");
  };
  const auto files = inspect_recorded(formats, options.recording, options.read, stop_if_interrupted);
  fmt::print("{}", options.json ? json_of(files, options.recording) : text_of(files, options.recording));
  return std::ranges::all_of(files, &RecordedFile::is_whole) ? 0 : 1;
}

int info(const InfoOptions& options, const FormatRegistry& formats) {
  if (is_run_folder(options) && has_parts(formats, options.recording))
    return info_of_folder(options, formats);
  const RecordingSummary info = summarise(options, formats);
  if (options.json) {
    print_json(info, options);
  } else {
    print_text(info, options);
  }
  return info.torn ? 1 : 0;
}

}  // namespace

void add_info_command(CommandLine& line, const Registry& registry) {
  auto options = std::make_shared<InfoOptions>();
  Command command = line.add_command(
      "info",
      "Content of a recording: format, image, count, duration, rates, ON and OFF, gaps, irregularities");
  add_read_options(command, "recording", "Event file, a folder with data.log, or a run folder", *options,
                   registry.formats);
  command.option("--gap", options->gap_ms, "Shortest time without events that counts as a gap, ms")
      .in_range(0.001, 1e9)
      .show_default();
  command.flag("--json", options->json, "As JSON");
  command.footer(
      "Peak rates are those of the fullest bin of 100 ms and of 1 ms; bins begin at the first event. Of a "
      "torn file "
      "the figures are those of its whole part, the line torn names what is lost, and the status is 1. Of "
      "the "
      "folder of a run with rotated or unfinished recordings: a line for each file.");
  command.action([options, &registry] { return info(*options, registry.formats); });
}

}  // namespace saccade
