#include "apps/cli/engine_options.h"

#include <string>
#include <vector>

namespace saccade {

void add_engine_options(Command& command, SweepEngineConfig& engine) {
  command.option("--engine", engine.engine, "local (xargs) or slurm (sbatch)")
      .show_default()
      .offers([]() -> std::vector<std::string> {
        return {"local", "slurm"};
      });
  command
      .option("--jobs", engine.jobs,
              "Runs at the same time; by default one per processor, for slurm as many as it likes")
      .in_range(1, 100000);
  command.option("--batch", engine.batch, "Runs in a row in one job or process").in_range(1, 100000);
  command.option("--sbatch", engine.sbatch_options,
                 "Further options for sbatch, such as \"--partition=short --time=1:00:00\"");
}

}  // namespace saccade
