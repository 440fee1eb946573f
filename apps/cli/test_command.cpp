#include <memory>

#include "apps/cli/commands.h"
#include "apps/sweep/scenario_tests.h"

namespace saccade {

void add_test_command(CommandLine& line, const Registry& registry) {
  auto options = std::make_shared<ScenarioTestOptions>();
  Command command = line.add_command("test", "Runs of many scenarios, held against what each one expects");
  command.option("scenarios", options->scenarios, "Scenario files (YAML)").required().offers_scenarios();
  command.option("--out", options->out, "Folder of the run folders").show_default();
  command.option("--junit", options->junit, "Write the results here as JUnit XML");
  command.option("--jobs", options->jobs, "Runs at the same time; by default one per processor")
      .in_range(1, 1000);
  command.option("--seed", options->seed, "Seed of every scenario, instead of its own");
  command.option("--set", options->assignments, "key.path=value for every scenario").one_value_each();
  command.flag("--force", options->force, "Replace runs that no test made, too");
  command.footer(
      "Each entry of `expect:` is a test case. Exit status: 0 all are met, 3 one is not met, 1 a run failed, "
      "2 "
      "bad input; then nothing is run. docs/ci.md has examples of workflow files.");
  command.action([options, &registry] { return test_scenarios(*options, registry); });
}

void add_test_task_command(CommandLine& line, const Registry& registry) {
  auto options = std::make_shared<TestTaskOptions>();
  Command command = line.add_command("test-task", "Makes runs of a test; started by `test`");
  command.hide();
  command.option("folder", options->folder, "Folder of the test").required();
  command.option("names", options->names, "Runs of it").required();
  command.action([options, &registry] { return make_test_runs(*options, registry); });
}

}  // namespace saccade
