#include <fmt/format.h>

#include <memory>

#include "apps/cli/commands.h"
#include "apps/cli/read_options.h"
#include "core/error.h"
#include "evaluation/report/film.h"
#include "recording/format_registry.h"
#include "recording/output_file.h"
#include "session/interrupt.h"
#include "session/progress.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;

struct FilmOptions : ReadOptions {
  fs::path out, truth;
  FilmConfig film;
  bool force = false;
};

int film(FilmOptions& options, const FormatRegistry& formats) {
  const fs::path events = formats.file_of(events_of(options));
  if (options.out.extension() != ".mp4")
    throw InputError("--out", options.out.string(), "a name that ends in .mp4");
  if (!(options.film.until_s > options.film.from_s))
    throw InputError("--until", fmt::format("{:g}", options.film.until_s),
                     fmt::format("more than --from, {:g}", options.film.from_s));
  check_outputs({{options.out}}, formats.inputs_of(events), options.force);
  RunData run;
  const bool of_run = is_run_folder(options);
  if (of_run && options.read.camera)
    throw InputError("--camera", *options.read.camera == 0 ? "left" : "right",
                     "none for a run, whose eyes are both drawn");
  if (of_run) run = load_run(options.recording, formats);
  if (!options.truth.empty()) run.truth = read_table<TruthRow>(options.truth);
  options.film.name = of_run ? run.metrics.scenario : options.recording.filename().string();
  catch_interrupts();
  Progress progress(100.0);
  const auto show = [&](double share) {
    if (interrupted()) throw RunError("interrupted; nothing was written");
    progress.show(100.0 * share, [&] { return fmt::format("{:.0f} %", 100.0 * share); });
  };
  const FilmResult result =
      write_film(formats, events, options.read, std::move(run), options.out, options.film, show);
  fmt::print("{}: {} images\n", options.out.string(), result.images);
  if (!result.guess.empty()) fmt::print("guessed: {}\n", result.guess);
  return 0;
}

}  // namespace

void add_film_command(CommandLine& line, const Registry& registry) {
  auto options = std::make_shared<FilmOptions>();
  Command command = line.add_command("film", "Draw a recording, or a run with its circles, as a video");
  add_read_options(command, "recording", "Event file, a folder with data.log, or a run folder", *options,
                   registry.formats);
  FilmConfig& config = options->film;
  command.option("--out", options->out, "Video to write (.mp4)").required();
  command.option("--truth", options->truth, "True circles (CSV); of a run folder its own by default");
  command.option("--speed", config.speed, "Time of the recording per time of the video; below 1: slow motion")
      .in_range(1e-4, 1e4)
      .show_default();
  command.option("--window-ms", config.window_ms, "An image shows the events of so long before it")
      .in_range(0.001, 1e6)
      .show_default();
  command.option("--from", config.from_s, "Begin at this time, s after the first event").in_range(0.0, 1e9);
  command.option("--until", config.until_s, "End at this time, s after the first event").in_range(0.0, 1e9);
  command.flag("--force", options->force, "Replace a file that exists");
  command.footer("25 images per second. The events of two cameras are drawn side by side.");
  command.action([options, &registry] { return film(*options, registry.formats); });
}

}  // namespace saccade
