#include <fmt/format.h>

#include <array>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "apps/cli/commands.h"
#include "apps/cli/program_digest.h"
#include "apps/sweep/benchmark_run.h"
#include "core/error.h"
#include "recording/output_file.h"
#include "sim/data_directory.h"

namespace saccade {
namespace {

struct BenchmarkCommand {
  std::vector<std::string> words;
  BenchmarkOptions options;
  std::filesystem::path html;
  bool force = false;
};

int print_table(const BenchmarkCommand& given, const std::vector<std::string>& files) {
  if (!given.html.empty()) {
    const std::array outputs{given.html};
    const std::vector<std::filesystem::path> inputs(files.begin(), files.end());
    check_outputs(outputs, inputs, given.force);
  }
  std::vector<BenchmarkResult> results;
  for (const std::string& file : files) results.push_back(read_benchmark_result(file));
  const std::vector<BenchmarkGroup> groups = groups_of(std::move(results));
  if (!given.html.empty()) write_benchmark_table(groups, given.html);
  fmt::print("{}", benchmark_table_text(groups));
  return 0;
}

int act(BenchmarkCommand given, const Registry& registry) {
  const std::string& verb = given.words.front();
  const std::vector<std::string> rest(given.words.begin() + 1, given.words.end());
  const bool is_verb = verb == "verify" || verb == "table";
  if (is_verb && rest.empty())
    throw InputError("saccade benchmark " + verb, "no file", "the result.json of an entry");
  if (verb == "table") return print_table(given, rest);
  if (given.options.out.empty()) throw InputError("saccade benchmark", "no --out", "--out FOLDER");
  if (given.options.list.empty()) given.options.list = "benchmarks/clutter_1";
  given.options.list = shipped_file(given.options.list);
  given.options.version = program_digest();
  if (verb != "verify") return benchmark(given.words, given.options, registry);
  if (rest.size() > 1)
    throw InputError("saccade benchmark verify", fmt::format("{} files", rest.size()), "one result.json");
  return verify_benchmark(rest.front(), given.options, registry);
}

}  // namespace

void add_benchmark_command(CommandLine& line, const Registry& registry) {
  auto given = std::make_shared<BenchmarkCommand>();
  BenchmarkOptions& options = given->options;
  Command command = line.add_command(
      "benchmark", "Detectors on a frozen list of worlds and closed loops; started again it goes on");
  command
      .option("words", given->words,
              "ENTRY...: detectors by name, files of one detector each, FILE.py:CLASS, or programs; verify "
              "RESULT: a tenth of a "
              "result.json again; table RESULT...: the table of several")
      .required()
      .offers([&registry] {
        std::vector<std::string> words = registry.detectors.names();
        words.insert(words.end(), {"verify", "table"});
        return words;
      });
  command.option("--out", options.out, "Folder of the entries, or of what verify repeats");
  command.option("--list", options.list, "List of runs (YAML); benchmarks/clutter_1 by default");
  command.flag("--quick", options.quick, "The few runs of the list that are for tests");
  command.option("--engine", options.engine.engine, "local (xargs) or slurm (sbatch)").show_default();
  command.option("--jobs", options.engine.jobs, "Runs at the same time; by default one per processor")
      .in_range(1, 100000);
  command.option("--class", options.latency_class,
                 "Class of the list's latencies for the entries; by default that of their preset");
  command.flag("--retry", options.retry, "Make the failed runs again");
  command.option("--html", given->html, "table: also write it as a page");
  command.flag("--force", given->force, "Replace the page of --html where it exists");
  command.footer(
      "Exit status: 0 fine, 1 a run failed, 3 verify found differences. docs/benchmark.md has the rules.");
  command.action([given, &registry] { return act(*given, registry); });
}

}  // namespace saccade
