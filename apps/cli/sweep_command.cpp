#include <filesystem>
#include <memory>

#include "apps/cli/commands.h"
#include "apps/cli/engine_options.h"
#include "apps/cli/program_digest.h"
#include "apps/cli/web_option.h"
#include "apps/sweep/sweep_run.h"
#include "apps/sweep/sweep_store.h"
#include "core/error.h"

namespace saccade {

void add_sweep_command(CommandLine& line, const Registry& registry) {
  auto options = std::make_shared<SweepOptions>();
  auto status_of = std::make_shared<std::filesystem::path>();
  Command command = line.add_command(
      "sweep", "Many runs of a scenario, on this machine or a Slurm cluster; started again it goes on");
  Option file = command.option("sweep", options->sweep, "Sweep file (YAML)");
  Option status = command.option("--status", *status_of, "Print how far the sweep in this folder is");
  status.excludes(file);
  command.option("--out", options->out, "Folder of the sweep; sweeps/NAME by default");
  add_web_option(command, options->web);
  command.option("--set", options->assignments, "key.path=value for the scenario of all runs")
      .one_value_each();
  add_engine_options(command, options->engine);
  command.option("--csv", options->csv, "Write the table here, too");
  command.flag("--times", options->times, "With the columns that depend on the clock");
  command.flag("--retry", options->retry, "Make the failed runs again");
  command.action([options, status_of, &registry] {
    if (!status_of->empty()) {
      print_sweep_status(*status_of);
      return 0;
    }
    if (options->sweep.empty()) throw InputError("sweep", "neither a sweep file nor --status", "one of them");
    return sweep(*options, program_digest(), registry);
  });
}

}  // namespace saccade
