#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <vector>

#include "apps/cli/commands.h"
#include "apps/sweep/sweep_folder.h"
#include "apps/sweep/sweep_store.h"
#include "evaluation/replay/replay_page.h"
#include "evaluation/report/comparison.h"
#include "evaluation/report/report.h"
#include "evaluation/report/sweep_report.h"
#include "recording/run_file_names.h"
#include "session/summary.h"

namespace saccade {
namespace {

struct ReportOptions {
  std::vector<std::filesystem::path> runs;
  std::filesystem::path out;
  std::filesystem::path figures;
};

int report(const ReportOptions& options, const FormatRegistry& formats) {
  std::filesystem::path folder = options.out;
  const SweepFolder sweep(options.runs.front());
  if (options.runs.size() == 1 && folder.empty() && std::filesystem::exists(sweep.table())) {
    folder = sweep.path();
    write_sweep_report(SweepStore(sweep).table(), folder, options.figures);
  } else if (options.runs.size() == 1 && folder.empty()) {
    folder = options.runs.front();
    write_replay(folder, formats, folder / run_file::replay);
    write_report(folder, formats, options.figures);
  } else {
    if (folder.empty()) folder = "report";
    for (const std::string& duplicate : write_comparison(options.runs, folder, formats, options.figures)) {
      fmt::print(stderr, "saccade: {}\n", duplicate);
    }
  }
  print_page(folder);
  return 0;
}

}  // namespace

void add_report_command(CommandLine& line, const Registry& registry) {
  auto options = std::make_shared<ReportOptions>();
  Command command = line.add_command(
      "report",
      "Draw what folders hold: report.html of one run or of a sweep, in its folder, or one page over "
      "several runs; of one run also replay.html, which replays it");
  command
      .option("run", options->runs,
              "Run folders; seeds of the same scenario and settings go together. Or the folder of a sweep")
      .required();
  command.option("--out", options->out,
                 "Folder for the page over several runs and its numbers; `report` by default");
  command.option(
      "--figures", options->figures,
      "Folder for each figure as SVG, PDF and CSV at the size of a paper: 88 mm wide, or 181 mm where it has "
      "several panels");
  command.action([options, &registry] { return report(*options, registry.formats); });
}

}  // namespace saccade
