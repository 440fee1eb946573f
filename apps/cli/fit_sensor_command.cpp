#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "apps/cli/commands.h"
#include "apps/cli/read_options.h"
#include "config/scenario.h"
#include "config/stimulus_file.h"
#include "core/error.h"
#include "evaluation/sensor_fit/sensor_fit.h"
#include "evaluation/sensor_fit/sensor_page.h"
#include "recording/output_file.h"
#include "recording/recording_summary.h"
#include "session/interrupt.h"
#include "session/summary.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;

struct FitSensorOptions : ReadOptions {
  std::vector<fs::path> recordings;
  fs::path stimulus;
  fs::path out = "sensor_fit";
  std::string preset;
  fs::path config;
  std::int64_t seed = 1;
  bool still = false;
  bool force = false;
};

constexpr const char* preset_file = "sensor.yaml";

void stop_if_interrupted() {
  if (interrupted()) throw RunError("interrupted");
}

/// The name of a recording in the stimulus file.
std::string name_of(const fs::path& recording) {
  const fs::path path = recording.has_filename() ? recording : recording.parent_path();
  return fs::is_directory(path) ? path.filename().string() : path.stem().string();
}

SensorRecording read_recording(const fs::path& path, const Stimulus& stimulus,
                               const FitSensorOptions& options) {
  ReadOptions one = options;
  one.recording = path;
  one.read.camera = options.read.camera.value_or(0);
  const fs::path events_file = events_of(one);
  const RecordingSummary summary = summarise_recording(options.formats, events_file, one.read, 1'000'000'000,
                                                       [](std::int64_t) { stop_if_interrupted(); });
  const EventStatistics& events = summary.counter.all();
  if (events.count == 0) throw InputError(path.string(), "no events of the camera", "a recording with some");
  const std::optional<ImageSize> size = options.read.image_size ? options.read.image_size : summary.image;
  if (!size) throw InputError(path.string(), "no image size in the file", "--size WIDTHxHEIGHT");
  SensorRecording recording(name_of(path), stimulus, *size, events.first_us, events.newest_us);
  const std::unique_ptr<EventReader> reader = open_event_file(options.formats, events_file, one.read);
  constexpr std::size_t block_events = 1 << 16;
  std::vector<Event> block;
  while (reader->read(block, block_events) > 0) {
    stop_if_interrupted();
    recording.add(block);
    block.clear();
  }
  recording.finish();
  return recording;
}

/// What the recordings show; scenes at rest where `--still` stands alone.
StimulusFile stimuli_of(const FitSensorOptions& options) {
  if (!options.stimulus.empty()) return read_stimulus_file(options.stimulus);
  if (!options.still) throw InputError("--stimulus", "no file", "what was shown, or --still");
  StimulusFile file;
  for (const fs::path& path : options.recordings) file.stimuli.emplace_back(name_of(path), Stimulus{});
  return file;
}

std::vector<SensorRecording> read_recordings(const FitSensorOptions& options, const NamedStimuli& stimuli) {
  std::vector<SensorRecording> recordings;
  for (const fs::path& path : options.recordings) {
    const std::string name = name_of(path);
    const auto found =
        std::find_if(stimuli.begin(), stimuli.end(), [&](const auto& s) { return s.first == name; });
    if (found == stimuli.end()) {
      throw InputError(options.stimulus.string() + ": stimuli." + name, "no such key",
                       "what the recording " + path.string() + " shows");
    }
    const bool twice = std::any_of(recordings.begin(), recordings.end(),
                                   [&](const SensorRecording& r) { return r.name() == name; });
    if (twice)
      throw InputError(path.string(), "a second recording named " + name, "one recording of each name");
    recordings.push_back(read_recording(path, found->second, options));
  }
  return recordings;
}

void print(const SensorFit& fit) {
  fmt::print("{:<26}{:>12}{:>18}{:>9}  {}\n", "", "prior", "fitted", "+-", "decided by");
  for (const FittedParameter& p : fit.parameters) {
    fmt::print("{:<26}{:>12.4g}{:>18}{:>9}  {}\n", p.key, p.prior,
               p.identifiable ? fmt::format("{:.4g}", p.value) : "not identifiable",
               p.identifiable ? fmt::format("{:.1f} %", 100.0 * p.deviation) : "-", p.decided_by);
  }
  for (const StillFit& s : fit.still) {
    if (!s.limit.empty()) fmt::print("{}: no threshold / noise: {}\n", s.recording, s.limit);
  }
  std::size_t width = 17;
  for (const ComparedDistribution& d : fit.distributions) width = std::max(width, d.recording.size());
  fmt::print("\n{:<{}} {:<52}{:>10}{:>10}\n", "KS distance of", width, "", "prior", "fitted");
  for (const ComparedDistribution& d : fit.distributions)
    fmt::print("{:<{}} {:<52}{:>10.3f}{:>10.3f}\n", d.recording, width, d.quantity, d.ks_before, d.ks_after);
}

/// Creates the folder; one with other files than those of a fit is rejected.
void prepare(const fs::path& folder, bool force) {
  if (fs::exists(folder) && !fs::is_directory(folder))
    throw InputError(folder.string(), "a file that exists", "a new folder");
  if (fs::exists(folder) && !fs::is_empty(folder)) {
    if (!force || !fs::exists(folder / preset_file)) {
      throw InputError(folder.string(), "a folder that is not empty",
                       force ? "a folder of an earlier fit" : "a new name, or --force");
    }
    fs::remove(folder / preset_file);
  }
  fs::create_directories(folder);
}

int fit(const FitSensorOptions& options) {
  if (fs::exists(options.out) && !options.force && !fs::is_empty(options.out))
    throw InputError(options.out.string(), "a folder that is not empty", "a new name, or --force");
  const StimulusFile stimuli = stimuli_of(options);
  const bool any_still = std::any_of(stimuli.stimuli.begin(), stimuli.stimuli.end(),
                                     [](const auto& s) { return !s.second.moves(); });
  if (options.still && !any_still)
    throw InputError(options.stimulus.string() + ": stimuli", "none of kind still", "one for --still");
  std::vector<std::string> assignments;
  if (!options.preset.empty()) assignments.push_back("preset=" + options.preset);
  SensorFitConfig config;
  config.prior = read_emulator(options.config, assignments);
  config.prior.white = stimuli.white;
  config.prior.dark_current = stimuli.dark_current;
  config.seed = static_cast<std::uint64_t>(options.seed);
  config.still = options.still;
  config.known_light = !options.stimulus.empty();
  config.progress = [](const std::string& line) {
    stop_if_interrupted();
    fmt::print(stderr, "{}\n", line);
  };
  catch_interrupts();
  std::vector<SensorRecording> recordings = read_recordings(options, stimuli.stimuli);
  const SensorFit result = fit_sensor(recordings, config);
  prepare(options.out, options.force);
  write_file(options.out / "fit.json", sensor_fit_json(result));
  write_sensor_page(result, options.out);
  write_file(options.out / preset_file, sensor_fit_remark(result) + emulator_yaml(result.config));
  print(result);
  fmt::print("{}\n", (options.out / preset_file).string());
  print_page(options.out);
  return 0;
}

}  // namespace

void add_fit_sensor_command(CommandLine& line, const Registry& registry) {
  auto options = std::make_shared<FitSensorOptions>();
  Command command = line.add_command(
      "fit-sensor", "The parameters of an event camera from its recordings of known stimuli, as a preset");
  command
      .option("recording", options->recordings, "Event files or run folders, each named in the stimulus file")
      .required();
  command.option("--stimulus", options->stimulus,
                 "What was shown (YAML; docs/fit_sensor.md); not needed with --still");
  command.flag("--still", options->still,
               "Also thresholds over noise and the bandwidth of scenes at rest; without --stimulus all are");
  command.option("--out", options->out, "Folder for sensor.yaml, report.html and fit.json").show_default();
  command.option("--preset", options->preset, "Event camera whose values are the prior; dvs128 by default")
      .one_of(emulator_presets());
  command.option("--config", options->config, "Event camera (YAML) whose values are the prior");
  add_decoding_options(command, *options, registry.formats);
  command.option("--seed", options->seed, "Seed of the emulator's noise").in_range(0, 9e15).show_default();
  command.flag("--force", options->force, "Replace an earlier fit in the folder --out");
  command.action([options] { return fit(*options); });
}

}  // namespace saccade
