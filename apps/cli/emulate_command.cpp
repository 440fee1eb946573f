#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>

#include "apps/cli/commands.h"
#include "config/scenario.h"
#include "core/error.h"
#include "evaluation/scoring/metrics.h"
#include "images/emulation.h"
#include "recording/output_file.h"
#include "session/interrupt.h"
#include "session/progress.h"

namespace saccade {
namespace {

struct EmulateOptions {
  EmulationConfig emulation;
  std::filesystem::path config;
  std::string preset;
  std::vector<std::string> assignments;
  bool force = false;
};

void print_summary(const std::filesystem::path& out, const EmulationResult& result) {
  const EmulatorCounts& counts = result.counts;
  const double duration_s = static_cast<double>(result.last_us - result.first_us) * 1e-6;
  const double rate_hz = static_cast<double>(counts.events()) / duration_s;
  const ImageSize size = result.info.size;
  fmt::print("images         {}, {} x {}\n", result.images, size.width, size.height);
  if (result.info.skipped_files > 0)
    fmt::print("skipped        {} that are no images\n", result.info.skipped_files);
  fmt::print("time           {} us to {} us, {:.6f} s\n", result.first_us, result.last_us, duration_s);
  fmt::print("luminance      {:.6g} to {:.6g}\n", result.least_luminance, result.largest_luminance);
  fmt::print("events         {}\n", counts.events());
  fmt::print("rate           {:.0f} events/s, {:.4g} per second and pixel\n", rate_hz,
             rate_hz / size.pixels());
  fmt::print("ON : OFF       {} : {}\n", counts.on, counts.off);
  std::string causes;
  for (std::size_t i = 0; i < event_cause_names.size(); ++i) {
    if (counts.by_cause[i] == 0) continue;
    causes += fmt::format("{}{} {}", causes.empty() ? "" : ", ", event_cause_names[i], counts.by_cause[i]);
  }
  if (!causes.empty()) fmt::print("by cause       {}\n", causes);
  fmt::print("dropped        {}\n", counts.dropped);
  fmt::print("{}\n", out.string());
}

void print_warnings(const EmulationConfig& config, const EmulationResult& result) {
  const std::string images = config.images.string();
  if (result.info.count > 0 && result.images != result.info.count) {
    fmt::print(stderr, "saccade: {}: read {} images where the file's header has {}\n", images, result.images,
               result.info.count);
  }
  const std::string dropped =
      dropped_warning("the event camera", result.counts.events(), result.counts.dropped);
  if (!dropped.empty()) fmt::print(stderr, "saccade: {}: {}\n", images, dropped);
  const std::string range =
      result.info.linear ? luminance_warning(config.emulator, result.largest_luminance) : "";
  if (!range.empty()) fmt::print(stderr, "saccade: {}: {} (--set KEY=VALUE)\n", images, range);
}

void check_files(const EmulateOptions& options, const FormatRegistry& formats) {
  const EmulationConfig& config = options.emulation;
  std::vector<std::filesystem::path> outputs = formats.files_of(config.out);
  if (!config.labels.empty()) {
    if (config.labels == config.out) {
      throw InputError("--labels", config.labels.string(), "another file than the events'");
    }
    outputs.push_back(config.labels);
  }
  const std::array<std::filesystem::path, 3> inputs = {config.images, config.timestamps, options.config};
  check_outputs(outputs, inputs, options.force);
}

int emulate(EmulateOptions options, const FormatRegistry& formats) {
  std::vector<std::string> assignments = options.assignments;
  if (!options.preset.empty()) assignments.insert(assignments.begin(), "preset=" + options.preset);
  EmulationConfig& config = options.emulation;
  config.emulator = read_emulator(options.config, assignments);
  constexpr Range seeds{0.0, 9e15};
  if (!seeds.contains(static_cast<double>(config.seed))) {
    throw InputError("--seed", std::to_string(config.seed), expectation_of(seeds, "a whole number"));
  }
  check_files(options, formats);
  catch_interrupts();
  std::optional<Progress> progress;
  const auto begin = std::chrono::steady_clock::now();
  const auto show = [&](std::int64_t images, std::int64_t expected) {
    if (interrupted()) throw RunError("interrupted; nothing was written");
    if (!progress) progress.emplace(static_cast<double>(expected));
    progress->show(static_cast<double>(images), [&] {
      const double wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
      const std::string total = expected > 0 ? fmt::format(" of {}", expected) : "";
      return fmt::format("{:6}{} images, {:6.0f} images/s", images, total,
                         static_cast<double>(images) / std::max(wall_s, 1e-9));
    });
  };
  const EmulationResult result = emulate_images(config, formats, show);
  if (progress) progress->done();
  print_warnings(config, result);
  print_summary(config.out, result);
  return 0;
}

}  // namespace

void add_emulate_command(CommandLine& line, const Registry& registry) {
  auto options = std::make_shared<EmulateOptions>();
  EmulationConfig& emulation = options->emulation;
  Command command =
      line.add_command("emulate", "The event camera alone: images or a video in, an event file out");
  command.option("images", emulation.images, "Folder of images, video, or NumPy array (.npy)").required();
  command.option("--out", emulation.out, "Event file to write: " + registry.formats.written_extensions())
      .required();
  command.option("--preset", options->preset, "Event camera, as --set preset=NAME").offers(emulator_presets);
  command.option("--config", options->config, "Event camera (YAML), as a scenario's block `emulator`");
  command.option("--set", options->assignments, "key=value of the event camera").one_value_each();
  const Option fps =
      command.option("--fps", emulation.images_per_s,
                     "Images per second; by default a video's own times; else needed without --timestamps");
  command
      .option("--timestamps", emulation.timestamps,
              "Times, one a line, in the unit of the first line (timestamp [ns]) or of --time-unit, else us, "
              "or s "
              "with a decimal point; an image's name may follow")
      .excludes(fps);
  command
      .option(
          "--time-unit", [&emulation](const std::string& word) { emulation.time_unit = time_unit_of(word); },
          "Unit of the --timestamps: s, ms, us or ns")
      .one_of({"s", "ms", "us", "ns"});
  command.option("--seed", emulation.seed, "Seed of all noise of the camera").show_default();
  command.option("--labels", emulation.labels, "What caused each event, t_us,x,y,p,cause (CSV)");
  command.option("--threads", emulation.threads, "Processor cores to use; the result does not depend on it")
      .in_range(1, 64)
      .show_default();
  command.flag("--force", options->force, "Replace files that exist");
  command.action([options, &registry] { return emulate(*options, registry.formats); });
}

}  // namespace saccade
