#include <fmt/format.h>

#include <memory>

#include "apps/cli/commands.h"
#include "apps/cli/read_options.h"
#include "apps/cli/recorded_text.h"
#include "core/error.h"
#include "recording/recorded_folder.h"
#include "recording/run_file_names.h"
#include "session/interrupt.h"
#include "session/recovered_run.h"

namespace saccade {
namespace {

/// Makes the folder of a run that was ended complete. Returns false where it should have a metrics.json and cannot.
bool complete(const std::filesystem::path& folder, const Registry& registry) {
  try {
    if (complete_run_folder(folder, registry))
      fmt::print("{}: scored as far as its tables go\n", (folder / run_file::report).string());
    return true;
  } catch (const InputError& error) {
    fmt::print(stderr, "saccade: {}: no metrics.json: {}\n", folder.string(), error.what());
    return false;
  }
}

int repair(const ReadOptions& options, const Registry& registry) {
  const FormatRegistry& formats = registry.formats;
  catch_interrupts();
  const auto stop_if_interrupted = [](std::int64_t) {
    if (interrupted()) throw RunError("interrupted");
  };
  const auto files = inspect_recorded(formats, options.recording, options.read, stop_if_interrupted);
  int status = 0;
  std::size_t whole = 0;
  for (const RecordedFile& file : files) {
    if (file.is_whole()) {
      ++whole;
    } else if (!file.unreadable.empty()) {
      fmt::print("{}: cannot be read: {}\n", file.path.string(), file.unreadable);
      status = 1;
    } else {
      const std::filesystem::path out = write_whole_part(formats, file, options.read);
      fmt::print("{}: {} {}{}\n", out.string(), file.rows, file.has_events ? "events" : "rows",
                 file.torn ? "; " + text_of(*file.torn) : "");
    }
  }
  if (whole > 0) fmt::print("{} {} whole\n", whole, whole == 1 ? "file is" : "files are");
  if (std::filesystem::is_directory(options.recording) && !complete(options.recording, registry)) status = 1;
  return status;
}

}  // namespace

void add_repair_command(CommandLine& line, const Registry& registry) {
  auto options = std::make_shared<ReadOptions>();
  Command command =
      line.add_command("repair",
                       "Write the whole part of files that a power cut or a full disk has torn, and "
                       "the figures of a run that was ended");
  add_read_options(command, "recording", "Event file or table, or the folder of a run", *options,
                   registry.formats);
  command.footer(
      "Of NAME.part it writes NAME, of another file NAME_whole.EXT beside it. The torn file stays as it is. "
      "The folder of a run without metrics.json gets one, and a report, from its tables. "
      "`saccade info` on the same path only prints what is lost. Use it when the recording has ended. Status "
      "1 where "
      "nothing of a file can be read.");
  command.action([options, &registry] { return repair(*options, registry); });
}

}  // namespace saccade
