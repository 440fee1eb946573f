#include <memory>

#include "apps/cli/commands.h"
#include "apps/sweep/sweep_task.h"

namespace saccade {

void add_sweep_task_command(CommandLine& line, const Registry& registry) {
  auto options = std::make_shared<SweepTaskOptions>();
  Command command =
      line.add_command("sweep-task", "Makes runs of a sweep; started by the engines of `sweep`");
  command.hide();
  command.option("folder", options->folder, "Folder of the sweep").required();
  command.option("ids", options->ids, "Runs of it").required();
  command.flag("--worst", options->worst, "Make them again, with pictures and a report");
  command.flag("--benchmark", options->benchmark, "With what the benchmark needs");
  command.flag("--dataset", options->dataset, "With the files of a data set");
  command.action([options, &registry] { return make_sweep_runs(*options, registry); });
}

}  // namespace saccade
