#include <memory>

#include "apps/cli/commands.h"
#include "apps/cli/read_options.h"
#include "apps/view/label_window.h"
#include "core/error.h"
#include "recording/output_file.h"
#include "session/interrupt.h"

namespace saccade {
namespace {

struct LabelOptions {
  LabelSettings settings;
  bool force = false;
};

/// "recording.truth.csv" in the working folder for "data/recording.aedat4".
std::filesystem::path default_out(const std::filesystem::path& recording) {
  std::filesystem::path name = std::filesystem::absolute(recording).lexically_normal();
  if (!name.has_filename()) name = name.parent_path();
  return name.stem().string() + ".truth.csv";
}

int label(LabelOptions& options) {
  LabelSettings& settings = options.settings;
  if (settings.out.empty()) settings.out = default_out(settings.input.recording);
  if (!options.force && std::filesystem::exists(settings.out))
    throw InputError(settings.out.string(), "a file that exists",
                     "another name with --out, or --force to go on with its circles and replace it");
  const FormatRegistry& formats = settings.input.formats;
  check_outputs({{settings.out}}, formats.inputs_of(formats.file_of(events_of(settings.input))), true);
  catch_interrupts();
  label_recording(settings);
  return 0;
}

}  // namespace

void add_label_command(CommandLine& line, const Registry& registry) {
  auto options = std::make_shared<LabelOptions>();
  LabelSettings& settings = options->settings;
  Command command = line.add_command("label", "Place the true circles of a recording in a window");
  add_read_options(command, "recording", "Event file, a folder with data.log, or a run folder",
                   settings.input, registry.formats);
  command.option(
      "--out", settings.out,
      "Table to write, t_us,x_px,y_px,r_px,visible,... (CSV); RECORDING's name with .truth.csv by default");
  command.flag("--force", options->force, "Go on with the circles of a table that exists, and replace it");
  command.option("--step-ms", settings.step_ms, "Step of the arrow keys, ms; with Shift ten steps")
      .in_range(0.001, 1e6)
      .show_default();
  command.option("--pictures", settings.pictures, "Folder for screenshots; . by default");
  command.footer(
      "A click places a circle, a drag moves it or changes its radius. Between two instants the line between "
      "their circles is the hint. The window lists the keys; W saves.\n"
      "It needs an X display; without a screen use xvfb-run. `detect --truth` and `score --truth` read the "
      "table.");
  command.action([options] { return label(*options); });
}

}  // namespace saccade
