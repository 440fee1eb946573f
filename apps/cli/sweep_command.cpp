#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "apps/cli/commands.h"
#include "apps/session/interrupt.h"
#include "apps/session/progress.h"
#include "apps/session/version.h"
#include "apps/sweep/sweep_config.h"
#include "apps/sweep/sweep_engine.h"
#include "apps/sweep/sweep_folder.h"
#include "apps/sweep/sweep_plan.h"
#include "apps/sweep/sweep_store.h"
#include "evaluation/report/sweep_report.h"
#include "recording/output_file.h"
#include "sim/world.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr int rounds_without_progress = 3;

struct SweepOptions {
  fs::path sweep;
  fs::path out;
  fs::path status;
  fs::path csv;
  bool times = false;
  bool retry = false;
  std::vector<std::string> assignments;
  SweepEngineConfig engine;
};

std::string bytes_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// The program itself and the models that it reads.
std::string version_of_program() {
  std::string bytes = bytes_of("/proc/self/exe");
  std::vector<fs::path> models;
  for (const auto& entry : fs::directory_iterator(models_directory())) models.push_back(entry.path());
  std::sort(models.begin(), models.end());
  for (const fs::path& model : models) bytes += bytes_of(model);
  return fmt::format("saccade {} ({}) {}, MuJoCo {}", version(), commit(), digest(bytes), mj_versionString());
}

void write_text(const fs::path& path, const std::string& text) {
  OutputFile file(path);
  file.write(text);
  file.commit();
}

std::vector<std::string> distinct(const std::vector<std::string>& ids) {
  std::set<std::string> seen;
  std::vector<std::string> all;
  for (const std::string& id : ids)
    if (seen.insert(id).second) all.push_back(id);
  return all;
}

std::string duration_text(double s) {
  if (s < 100.0) return fmt::format("{:.0f} s", s);
  if (s < 6000.0) return fmt::format("{:.0f} min", s / 60.0);
  return fmt::format("{:.1f} h", s / 3600.0);
}

/// Bad usage and a bad sweep file, all at once.
SweepPlan checked_plan(const SweepOptions& options, const Registry& registry) {
  std::vector<Problem> problems;
  const auto collect = [&](const auto& work) {
    try {
      work();
    } catch (const InputError& error) {
      problems.insert(problems.end(), error.problems().begin(), error.problems().end());
    }
  };
  SweepPlan plan;
  collect([&] { check_engine(options.engine); });
  collect([&] {
    plan = plan_sweep(read_sweep(options.sweep, options.assignments), version_of_program(), registry);
  });
  if (!problems.empty()) throw InputError(std::move(problems));
  return plan;
}

void prepare_folder(const SweepFolder& sweep, const SweepPlan& plan) {
  const fs::path& path = sweep.path();
  std::error_code error;
  if (fs::exists(path, error) && !fs::is_directory(path, error)) {
    throw InputError(path.string(), "a file", "a folder for the sweep");
  }
  if (fs::exists(sweep.table(), error)) {
    const std::string name = SweepStore(sweep).name();
    if (name != plan.config.name) {
      throw InputError(path.string(), "the sweep " + name, "a folder of its own for " + plan.config.name);
    }
  } else if (fs::exists(path, error) && !fs::is_empty(path, error) && !fs::exists(path / "lock", error)) {
    throw InputError(path.string(), "a folder with other files in it", "a new folder, or that of this sweep");
  }
  fs::create_directories(path / "runs", error);
  if (error) throw RunError(path.string() + ": cannot make the folder: " + error.message());
}

/// A sweep from what is missing to the whole table.
class Coordinator {
 public:
  Coordinator(const SweepOptions& options, const SweepPlan& plan, const SweepFolder& sweep)
      : plan_(plan), sweep_(sweep), engine_(make_engine(options.engine, sweep.path())) {
    std::set<std::string> seen;
    for (const PlannedRun& run : plan.runs) {
      if (!seen.insert(run.id).second) continue;
      const fs::path folder = sweep_.run(run.id);
      if (options.retry) fs::remove(folder / "failure.txt");
      if (sweep_.has_result(run.id)) continue;
      fs::create_directories(folder);
      // No run waits for this file to be safe on the disk: the next start writes it again.
      std::ofstream(folder / "scenario.yaml", std::ios::binary) << run.scenario;
      if (bytes_of(folder / "scenario.yaml") != run.scenario) {
        throw DiskFull((folder / "scenario.yaml").string() + ": cannot be written");
      }
      missing_.push_back(run.id);
    }
    distinct_ = seen.size();
    SweepStore::create(sweep_, plan_);
    store_ = std::make_unique<SweepStore>(sweep_);
  }

  [[nodiscard]] SweepStore& store() { return *store_; }

  /// Throws RunError when it was interrupted, DiskFull.
  void make_missing_runs() {
    const std::size_t had = distinct_ - missing_.size();
    fmt::print(stderr, "{} runs, {} of them different; {} are there\n", plan_.runs.size(), distinct_, had);
    Progress progress(static_cast<double>(missing_.size()));
    const std::size_t to_do = missing_.size();
    const auto begin = Clock::now();
    const auto show = [&] {
      const std::size_t done = to_do - missing_.size();
      if (done == 0) return;
      progress.show(static_cast<double>(done), [&] {
        const double elapsed_s = std::chrono::duration<double>(Clock::now() - begin).count();
        const double rate_hz = static_cast<double>(done) / std::max(elapsed_s, 1e-3);
        return fmt::format("{} of {} done, {} failed, {} running, {:.2g} runs/s, {} left", had + done,
                           distinct_, store_->count("failed"), running(), rate_hz,
                           duration_text(static_cast<double>(missing_.size()) / rate_hz));
      });
    };
    int idle_rounds = 0;
    wait(show);  // for what an earlier start has left in a queue
    while (!missing_.empty()) {
      const std::size_t before = missing_.size();
      engine_->start(command({}), missing_);
      wait(show);
      idle_rounds = missing_.size() < before ? 0 : idle_rounds + 1;
      if (idle_rounds == rounds_without_progress) give_up();
    }
    progress.done();
  }

  /// Makes the worst runs again, for their reports. What fails there is not needed.
  void make_worst_runs() {
    std::vector<std::string> ids;
    const SweepTable table = store_->table();
    for (const SweepRow* row : worst_runs(table)) {
      if (!fs::exists(sweep_.worst(row->id) / "report.html")) ids.push_back(row->id);
    }
    if (ids.empty()) return;
    fmt::print(stderr, "{} of the worst runs again, for their reports\n", ids.size());
    engine_->start(command({"--worst"}), ids);
    while (engine_->busy()) pause(0.2);
    for (const std::string& id : ids) {
      std::error_code ignored;
      const fs::path log = sweep_.run(id) / "log.txt";
      if (fs::exists(sweep_.worst(id) / "report.html")) fs::remove(log, ignored);
    }
  }

 private:
  [[nodiscard]] std::vector<std::string> command(const std::vector<std::string>& flags) const {
    std::vector<std::string> words = {fs::read_symlink("/proc/self/exe").string(), "sweep-task"};
    words.insert(words.end(), flags.begin(), flags.end());
    words.push_back(sweep_.path().string());
    return words;
  }

  void pause(double s) {
    std::this_thread::sleep_for(std::chrono::duration<double>(s));
    if (!interrupted()) return;
    engine_->stop();
    const std::string after = engine_->after_stop();
    throw RunError("interrupted; the same command goes on where it was" +
                   (after.empty() ? "" : "; " + after));
  }

  /// Collects results until the engine has no more to do.
  template <class Show>
  void wait(const Show& show) {
    for (bool busy = true; busy;) {
      busy = engine_->busy();
      const auto begin = Clock::now();
      collect();
      show();
      const double cost_s = std::chrono::duration<double>(Clock::now() - begin).count();
      if (busy) pause(std::max(0.2, 20.0 * cost_s));
    }
  }

  void collect() {
    const auto found = std::stable_partition(missing_.begin(), missing_.end(),
                                             [&](const std::string& id) { return !sweep_.has_result(id); });
    if (found == missing_.end()) return;
    store_->add({found, missing_.end()});
    missing_.erase(found, missing_.end());
  }

  [[nodiscard]] std::ptrdiff_t running() const {
    return std::count_if(missing_.begin(), missing_.end(),
                         [&](const std::string& id) { return sweep_.is_running(id); });
  }

  /// The engine came to its end several times and nothing new was there.
  void give_up() {
    constexpr std::uintmax_t little = 1 << 20;
    if (fs::space(sweep_.path()).available < little) {
      throw DiskFull(sweep_.path().string() + ": the disk is full");
    }
    for (const std::string& id : missing_) {
      write_text(sweep_.run(id) / "failure.txt",
                 fmt::format("no result after {} attempts: it was killed or never started\n",
                             rounds_without_progress));
    }
    collect();
  }

  const SweepPlan& plan_;
  SweepFolder sweep_;
  std::unique_ptr<SweepEngine> engine_;
  std::unique_ptr<SweepStore> store_;
  std::vector<std::string> missing_;
  std::size_t distinct_ = 0;
};

int sweep(const SweepOptions& options, const Registry& registry) {
  const SweepPlan plan = checked_plan(options, registry);
  const fs::path out = options.out.empty() ? fs::path("sweeps") / plan.config.name : options.out;
  const SweepFolder folder(fs::weakly_canonical(fs::absolute(out)));
  prepare_folder(folder, plan);
  const FileLock lock(folder.path() / "lock");
  if (!lock.held()) {
    throw InputError(folder.path().string(), "a sweep at work in it", "another folder, or wait for its end");
  }
  const std::string what_to_do = "; what is done is kept, and the same command goes on when there is room";
  catch_interrupts();
  try {
    Coordinator coordinator(options, plan, folder);
    coordinator.make_missing_runs();
    if (!options.csv.empty()) write_text(options.csv, coordinator.store().csv(options.times));
    coordinator.make_worst_runs();
    write_sweep_report(coordinator.store().table(), folder.path());
    const std::int64_t failed = coordinator.store().count("failed");
    fmt::print("{} runs done, {} failed\n{}\n", coordinator.store().count("done"), failed,
               (out / "report.html").string());
    return failed == 0 ? 0 : 1;
  } catch (const DiskFull& error) {
    throw RunError(error.what() + what_to_do);
  } catch (const fs::filesystem_error& error) {
    throw RunError(error.what() + what_to_do);
  }
}

int tell_status(const fs::path& path) {
  const SweepFolder folder(path);
  const SweepStore store(folder);
  const std::vector<std::string> ids = distinct(store.ids());
  const auto now = fs::file_time_type::clock::now();
  constexpr auto window = std::chrono::seconds(60);
  std::size_t done = 0;
  std::size_t failed = 0;
  std::size_t running = 0;
  std::size_t recent = 0;
  auto earliest = now;
  for (const std::string& id : ids) {
    if (const auto finished = folder.finished(id)) {
      const bool whole = fs::exists(folder.run(id) / "metrics.json");
      ++(whole ? done : failed);
      if (now - *finished > window) continue;
      ++recent;
      earliest = std::min(earliest, *finished);
    } else if (folder.is_running(id)) {
      ++running;
    }
  }
  const std::size_t waiting = ids.size() - done - failed - running;
  fmt::print("{}: {} of {} done, {} failed, {} running, {} waiting\n", store.name(), done, ids.size(), failed,
             running, waiting);
  const double recent_s = std::chrono::duration<double>(now - earliest).count();
  if (recent > 1 && running + waiting > 0) {
    const double rate_hz = static_cast<double>(recent - 1) / std::max(recent_s, 1e-3);
    fmt::print("{:.2g} runs/s, {} left\n", rate_hz,
               duration_text(static_cast<double>(running + waiting) / rate_hz));
  }
  const bool at_work = is_locked(folder.path() / "lock");
  if (!at_work && running + waiting > 0)
    fmt::print("no `saccade sweep` is at work here; starting it goes on\n");
  return 0;
}

}  // namespace

void add_sweep_command(CommandLine& line, const Registry& registry) {
  auto options = std::make_shared<SweepOptions>();
  Command command = line.add_command(
      "sweep", "Many runs of a scenario, on this machine or a Slurm cluster; started again it goes on");
  Option file = command.option("sweep", options->sweep, "Sweep file (YAML)");
  Option status = command.option("--status", options->status, "Tell how far the sweep in this folder is");
  status.excludes(file);
  command.option("--out", options->out, "Folder of the sweep; sweeps/NAME by default");
  command.option("--set", options->assignments, "key.path=value for the scenario of all runs")
      .one_value_each();
  command.option("--engine", options->engine.engine, "local (xargs) or slurm (sbatch)").show_default();
  command
      .option("--jobs", options->engine.jobs,
              "Runs at the same time; by default one per processor, for slurm as many as it likes")
      .in_range(1, 100000);
  command.option("--batch", options->engine.batch, "Runs in a row in one job or process").in_range(1, 100000);
  command.option("--sbatch", options->engine.sbatch_options,
                 "Further options for sbatch, such as \"--partition=short --time=1:00:00\"");
  command.option("--csv", options->csv, "Write the table here, too");
  command.flag("--times", options->times, "With the columns that depend on the clock");
  command.flag("--retry", options->retry, "Make the failed runs again");
  command.action([options, &registry] {
    if (options->sweep.empty() && options->status.empty())
      throw InputError("sweep", "neither a sweep file nor --status", "one of them");
    return options->status.empty() ? sweep(*options, registry) : tell_status(options->status);
  });
}

}  // namespace saccade
