#include <fmt/format.h>

#include <array>
#include <filesystem>
#include <memory>
#include <vector>

#include "apps/cli/commands.h"
#include "apps/cli/read_options.h"
#include "apps/view/view.h"
#include "config/scenario.h"
#include "core/error.h"
#include "evaluation/replay/foxglove_file.h"
#include "evaluation/replay/replay_page.h"
#include "recording/output_file.h"
#include "recording/run_file_names.h"
#include "session/interrupt.h"
#include "session/scenario_loop.h"
#include "session/version.h"
#include "sim/data_directory.h"

namespace saccade {
namespace {

struct ViewOptions : ReadOptions {
  std::filesystem::path config, truth;
  std::filesystem::path pictures = ".";
  std::vector<std::string> assignments;
  std::optional<std::int64_t> seed;
  bool paused = false;
  std::filesystem::path html, mcap;
  double fps = foxglove_images_hz;
  bool force = false;
};

/// The scenario with what the user has set.
std::string scenario_with(Scenario scenario, const ViewSettings& settings) {
  scenario.detectors = settings.enabled();
  if (settings.gate) {
    scenario.gaze.detector = settings.selected_name();
    scenario.gaze.gate = *settings.gate;
  }
  if (settings.controller) scenario.gaze.controller = *settings.controller;
  return version_line() + "; saved in the window\n" + resolved_scenario(scenario);
}

int view_scenario(const ViewOptions& options, const Registry& registry) {
  const Scenario scenario = read_scenario(options.recording, options.assignments, options.seed, registry);
  set_rasterisers(1);
  View view(scenario.name, options.pictures, registry.detectors);
  view.set_save([&](const ViewSettings& settings) { return scenario_with(scenario, settings); }, "_saved");
  set_rasterisers(scenario.run.threads);
  PlayerThread player([&] { return make_scenario_playback(scenario); }, !options.paused);
  view.show(player);
  return 0;
}

int view_recording(const ViewOptions& options, const Registry& registry) {
  NamedDetectors detectors;
  std::string selected = "best";
  std::optional<RecordedDetectors> own;
  if (options.config.empty() && is_run_folder(options))
    own = read_recorded_detectors(options.recording, options.assignments, registry.detectors);
  if (own) {
    detectors = std::move(own->detectors);
    if (own->file.filename() == run_file::scenario)
      selected = read_scenario(own->file, {}, std::nullopt, registry).gaze.detector;
  } else {
    detectors = read_detectors(options.config, options.assignments, registry.detectors);
  }
  std::filesystem::path name = std::filesystem::absolute(options.recording).lexically_normal();
  if (!name.has_filename()) name = name.parent_path();
  set_rasterisers(1);
  View view(std::filesystem::is_directory(name) ? name.filename() : name.stem(), options.pictures,
            registry.detectors);
  view.set_save(
      [](const ViewSettings& settings) {
        return version_line() + "; saved in the window\n" + resolved_detectors(settings.enabled());
      },
      "_detectors");
  PlayerThread player(
      [&] { return make_recording_playback(options, options.truth, detectors, selected, registry); },
      !options.paused);
  view.show(player);
  return 0;
}

void write_mcap(const ViewOptions& options, const Registry& registry) {
  const FoxgloveSummary summary =
      write_foxglove(options.recording, registry.formats, options.fps, options.mcap);
  if (summary.late_events > 0) {
    fmt::print(stderr,
               "saccade: {}: {} events follow others that are more than 100 ms newer; no image has them\n",
               options.recording.string(), summary.late_events);
  }
  fmt::print("{}\n", options.mcap.string());
}

/// Files instead of a window.
int write_files(const ViewOptions& options, const Registry& registry) {
  const std::filesystem::path extension = options.recording.extension();
  if (extension == ".yaml" || extension == ".yml")
    throw InputError(options.html.empty() ? "--mcap" : "--html", "the scenario " + options.recording.string(),
                     "the folder of a run (`saccade run` makes one) or a recording");
  if (!options.mcap.empty() && !is_run_folder(options))
    throw InputError("--mcap", options.recording.string(),
                     "the folder of a run; `saccade convert` writes the events of a recording as MCAP");
  std::vector<std::filesystem::path> outputs;
  for (const std::filesystem::path& file : {options.html, options.mcap}) {
    if (!file.empty()) outputs.push_back(file);
  }
  const std::array inputs{options.recording};
  check_outputs(outputs, inputs, options.force);
  if (!options.mcap.empty()) write_mcap(options, registry);
  if (options.html.empty()) return 0;
  if (is_run_folder(options))
    write_replay(options.recording, registry.formats, options.html);
  else
    write_recording_replay(options.recording, registry.formats, options.read, options.html);
  fmt::print("{}\n", options.html.string());
  return 0;
}

int view(const ViewOptions& options, const Registry& registry) {
  if (!options.html.empty() || !options.mcap.empty()) return write_files(options, registry);
  catch_interrupts();
  const std::filesystem::path extension = shipped_file(options.recording).extension();
  return extension == ".yaml" || extension == ".yml" ? view_scenario(options, registry)
                                                     : view_recording(options, registry);
}

}  // namespace

void add_view_command(CommandLine& line, const Registry& registry) {
  auto options = std::make_shared<ViewOptions>();
  Command command = line.add_command("view", "Show a scenario, a run folder or a recording in a window");
  add_read_options(command, "what", "Scenario (YAML), run folder or event file", *options, registry.formats)
      .offers_scenarios();
  command.option("--config", options->config, "Detectors (YAML) for a recording");
  command.option("--truth", options->truth, "True circles of a recording, t_us,x_px,y_px,r_px (CSV)");
  command
      .option("--set", options->assignments,
              "key.path=value of a scenario; key=value or DETECTOR.key=value for a recording")
      .one_value_each();
  command.option("--seed", options->seed, "Seed, instead of the scenario's");
  command.option("--pictures", options->pictures,
                 "Folder for screenshots, videos and saved settings; . by default");
  command.flag("--paused", options->paused, "Start paused");
  command.option("--html", options->html,
                 "Write a page that replays a run folder or a recording in a browser, instead of a window");
  command.option("--mcap", options->mcap,
                 "Write an MCAP file of a run folder for Foxglove, instead of a window");
  command.option("--fps", options->fps, "Images of the events per second of the run, of --mcap")
      .in_range(0.1, 1000.0)
      .show_default();
  command.flag("--force", options->force, "Replace the files of --html and --mcap where they exist");
  command.footer("H in the window lists its keys. It needs an X display; without a screen use xvfb-run.");
  command.action([options, &registry] { return view(*options, registry); });
}

}  // namespace saccade
