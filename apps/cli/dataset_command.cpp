#include <fmt/format.h>

#include <memory>
#include <string>
#include <vector>

#include "apps/cli/commands.h"
#include "apps/cli/engine_options.h"
#include "apps/cli/program_digest.h"
#include "apps/sweep/dataset_run.h"
#include "core/error.h"

namespace saccade {
namespace {

struct DatasetCommand {
  std::vector<std::string> words;
  DatasetOptions options;
};

int act(DatasetCommand given, const Registry& registry) {
  const std::vector<std::string>& words = given.words;
  const bool checks = words.front() == "check";
  if (checks && words.size() == 1)
    throw InputError("saccade dataset check", "no folder", "the folder of a data set");
  if (words.size() > (checks ? 2u : 1u))
    throw InputError("saccade dataset", fmt::format("{} words", words.size()), "FILE, or check FOLDER");
  if (checks) return check_dataset(words[1]);
  given.options.file = words.front();
  given.options.program = program_digest();
  return make_dataset(given.options, registry);
}

}  // namespace

void add_dataset_command(CommandLine& line, const Registry& registry) {
  auto given = std::make_shared<DatasetCommand>();
  DatasetOptions& options = given->options;
  Command command = line.add_command(
      "dataset", "Simulated runs as a data set with labels, splits and a card; started again it goes on");
  command
      .option(
          "words", given->words,
          "FILE: makes the data set that this file (YAML) describes; check FOLDER: compares every file of "
          "a data set with its card")
      .required()
      .offers([]() -> std::vector<std::string> { return {"check"}; });
  command.option("--out", options.out, "Folder of the data set; datasets/NAME by default");
  command.option("--set", options.assignments, "key.path=value for the scenario of all runs")
      .one_value_each();
  add_engine_options(command, options.engine);
  command.flag("--retry", options.retry, "Make the failed runs again");
  command.footer(
      "Exit status: 0 fine, 1 a run failed, 3 check found differences. docs/dataset.md explains it.");
  command.action([given, &registry] { return act(*given, registry); });
}

}  // namespace saccade
