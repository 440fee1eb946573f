#include "apps/sweep/sweep_task.h"

#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <fstream>
#include <functional>
#include <iterator>
#include <tuple>

#include "apps/sweep/benchmark_run.h"
#include "apps/sweep/child_process.h"
#include "apps/sweep/dataset_card.h"
#include "apps/sweep/processor_time.h"
#include "apps/sweep/sweep_engine.h"
#include "apps/sweep/sweep_folder.h"
#include "apps/sweep/sweep_plan.h"
#include "config/scenario.h"
#include "core/error.h"
#include "evaluation/scoring/metrics.h"
#include "recording/file_lock.h"
#include "recording/output_file.h"
#include "session/run_scenario.h"
#include "session/scenario_loop.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;

/// Makes the run in `folder`/scenario.yaml and leaves `folder`/metrics.json; what a benchmark or a data set needs first.
void make_run(const fs::path& folder, const SweepTaskOptions& options, const Registry& registry) {
  const Scenario scenario = read_scenario(folder / "scenario.yaml", {}, std::nullopt, registry);
  set_rasterisers(scenario.run.threads);
  const fs::path part = folder / "part";
  const bool writes_files = options.benchmark || options.dataset;
  if (writes_files) {
    fs::remove_all(part);
    fs::create_directory(part);
  }
  ProcessorTimes times;
  std::function<void(std::vector<LoopDetector>&)> wrap;
  if (options.benchmark) wrap = [&](std::vector<LoopDetector>& all) { times.measure(scenario, all); };
  Metrics metrics = writes_files ? score_scenario(scenario, part, wrap) : score_scenario(scenario);
  times.replace_costs(metrics);
  if (metrics.interrupted) throw RunError("interrupted");
  std::ifstream file(folder / "scenario.yaml", std::ios::binary);
  const std::string planned{std::istreambuf_iterator<char>(file), {}};
  for (const std::string& changed : changed_files(metrics.files, planned))
    throw RunError(changed + " has changed since the sweep was started; start it again");
  if (options.benchmark) write_benchmark_figures(part, folder / "benchmark.json");
  if (options.dataset) metrics.events_file = keep_dataset_run(part, folder);
  if (writes_files) fs::remove_all(part);
  write_metrics(folder / "metrics.json", metrics);
}

/// Makes a run in a process of its own, unless it has a result or another process makes it; notes a failure.
/// Throws DiskFull.
void make_run_in_process(const SweepFolder& sweep, const std::string& id, const SweepTaskOptions& options,
                         const Registry& registry) {
  const fs::path folder = sweep.run(id);
  if (sweep.has_result(id)) return;
  const fs::path log = folder / "log.txt";
  const FileLock lock(log);
  if (!lock.held() || sweep.has_result(id)) return;
  if (::ftruncate(lock.file(), 0) != 0) throw RunError(log.string() + ": cannot be written");
  const ChildEnd end = run_in_child(lock.file(), [&] {
    make_run(folder, options, registry);
    return 0;
  });
  const int status = end.status;
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) {
    if (fs::file_size(log) == 0) fs::remove(log);
    return;
  }
  const std::string why = failure_text(end, log);
  if (WIFEXITED(status) && WEXITSTATUS(status) == disk_full_status) throw DiskFull(why);
  if (was_stopped(status)) return;
  OutputFile failure(folder / "failure.txt");
  failure.write(why + "\n");
  failure.commit();
}

/// Makes a run once more, as `saccade run` does, with pictures and a report.
void make_worst(const SweepFolder& sweep, const std::string& id, const std::string& program) {
  const fs::path folder = sweep.worst(id);
  if (sweep.has_worst_report(id)) return;
  fs::create_directories(folder);
  const FileLock lock(sweep.run(id) / "log.txt");
  if (!lock.held()) return;
  std::ignore = run_in_child(lock.file(), [&] {
    const std::string scenario = (sweep.run(id) / "scenario.yaml").string();
    ::execl(program.c_str(), program.c_str(), "run", scenario.c_str(), "--set", "output.pictures=10",
            "--force", "--out", folder.c_str(), static_cast<char*>(nullptr));
    return 127;
  });
}

}  // namespace

int make_sweep_runs(const SweepTaskOptions& options, const Registry& registry) {
  const SweepFolder sweep(options.folder);
  die_with_parent(::getppid());
  try {
    for (const std::string& id : options.ids) {
      if (options.worst) {
        make_worst(sweep, id, fs::read_symlink("/proc/self/exe").string());
      } else {
        make_run_in_process(sweep, id, options, registry);
      }
    }
  } catch (const DiskFull& error) {
    fmt::print(stderr, "saccade: {}\n", error.what());
    return stop_all_status;
  }
  return 0;
}

}  // namespace saccade
