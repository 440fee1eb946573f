#include <fmt/format.h>

#include <array>
#include <filesystem>
#include <memory>
#include <vector>

#include "apps/cli/commands.h"
#include "apps/sweep/comparison_page.h"
#include "apps/sweep/run_comparison.h"
#include "recording/output_file.h"

namespace saccade {
namespace {

struct CompareOptions {
  std::filesystem::path a;
  std::filesystem::path b;
  std::vector<std::string> tolerances;
  bool paired = false;
  bool json = false;
  bool force = false;
  std::filesystem::path html;
};

int compare_sides(const CompareOptions& options) {
  if (!options.html.empty()) {
    const std::array outputs{options.html};
    check_outputs(outputs, {}, options.force);
  }
  std::vector<Tolerance> tolerances;
  for (const std::string& text : options.tolerances) tolerances.push_back(tolerance_of(text));
  const RunComparison comparison =
      compare(read_run_set(options.a), read_run_set(options.b), tolerances, options.paired);
  if (!options.html.empty()) write_comparison_page(comparison, options.html);
  fmt::print("{}", options.json ? comparison_json(comparison) : comparison_text(comparison));
  return comparison.different() ? 3 : 0;
}

}  // namespace

void add_compare_command(CommandLine& line) {
  auto options = std::make_shared<CompareOptions>();
  Command command =
      line.add_command("compare", "Figures that changed between two runs, sets of runs or sweeps");
  command.option("a", options->a, "Run folder, folder of run folders (several seeds), or folder of a sweep")
      .required();
  command.option("b", options->b, "The same of the version or the setting to compare with").required();
  command
      .option(
          "--tolerance", options->tolerances,
          "KEY=VALUE or KEY=VALUE%: the largest change of a figure that counts as equal; * in KEY stands for "
          "any characters; 0 by default")
      .one_value_each();
  command.flag(
      "--paired", options->paired,
      "Compare runs of the same seed with each other: shows changes that are smaller than the spread "
      "over seeds");
  command.flag("--json", options->json, "As JSON, all figures");
  command.option("--html", options->html, "Also write a page of all figures, to sort and to filter");
  command.flag("--force", options->force, "Replace the page of --html where it exists");
  command.footer(
      "A figure has changed if the means over seeds differ by more than its tolerance and, with two seeds or "
      "more on both sides, the t test gives p < 0.01: Welch's, or with --paired the paired one. Figures "
      "of the wall clock are not compared. Exit status: 0 equal within tolerance, 3 different, also where a "
      "run has "
      "no result or was interrupted.");
  command.action([options] { return compare_sides(*options); });
}

}  // namespace saccade
