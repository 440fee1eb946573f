#include "apps/sweep/sweep_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <set>

#include "apps/sweep/live_sweep.h"
#include "apps/sweep/sweep_config.h"
#include "apps/sweep/sweep_coordinator.h"
#include "apps/sweep/sweep_folder.h"
#include "apps/sweep/sweep_plan.h"
#include "apps/sweep/sweep_store.h"
#include "core/error.h"
#include "evaluation/report/sweep_report.h"
#include "recording/file_lock.h"
#include "recording/output_file.h"
#include "session/interrupt.h"
#include "session/summary.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> distinct(const std::vector<std::string>& ids) {
  std::set<std::string> seen;
  std::vector<std::string> all;
  for (const std::string& id : ids)
    if (seen.insert(id).second) all.push_back(id);
  return all;
}

/// Reports bad options and a bad sweep file together.
SweepPlan checked_plan(const SweepOptions& options, const std::string& version, const Registry& registry) {
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
  collect([&] { plan = plan_sweep(read_sweep(options.sweep, options.assignments), version, registry); });
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

}  // namespace

void make_sweep(const SweepPlan& plan, const fs::path& out, const SweepEngineConfig& engine, bool retry,
                const std::vector<std::string>& task_flags, const SweepStep& end, const SweepStep& begin) {
  const SweepFolder folder(fs::weakly_canonical(fs::absolute(out)));
  prepare_folder(folder, plan);
  const FileLock lock(folder.path() / "lock");
  if (!lock.held()) {
    throw InputError(folder.path().string(), "a sweep at work in it", "another folder, or wait for its end");
  }
  const std::string what_next = "; what is done is kept, and the same command goes on when there is room";
  catch_interrupts();
  try {
    SweepCoordinator coordinator(engine, plan, folder, retry, task_flags);
    if (begin) begin(coordinator, folder);
    coordinator.make_missing_runs();
    end(coordinator, folder);
  } catch (const DiskFull& error) {
    throw RunError(error.what() + what_next);
  } catch (const fs::filesystem_error& error) {
    throw RunError(error.what() + what_next);
  }
}

int sweep(const SweepOptions& options, const std::string& version, const Registry& registry) {
  const SweepPlan plan = checked_plan(options, version, registry);
  const fs::path out = options.out.empty() ? fs::path("sweeps") / plan.config.name : options.out;
  std::int64_t failed = 0;
  std::optional<LiveSweep> page;
  const auto begin = [&](SweepCoordinator& coordinator, const SweepFolder& folder) {
    if (!options.web) return;
    page.emplace(*options.web, folder);
    fmt::print(stderr, "live page: {}\n", page->link());
    coordinator.set_watch([&](const SweepCoordinator& now) { page->show(now); });
  };
  make_sweep(
      plan, out, options.engine, options.retry, {},
      [&](SweepCoordinator& coordinator, const SweepFolder& folder) {
        if (!options.csv.empty()) write_file(options.csv, coordinator.store().csv(options.times));
        coordinator.make_worst_runs();
        if (page) page->show(coordinator, LiveSweep::When::at_once);
        write_sweep_report(coordinator.store().table(), folder.path());
        failed = coordinator.store().count("failed");
        fmt::print("{} runs done, {} failed\n", coordinator.store().count("done"), failed);
        print_page(out);
      },
      begin);
  return failed == 0 ? 0 : 1;
}

void print_sweep_status(const fs::path& path) {
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
    fmt::print("no `saccade sweep` runs in this folder; start it to continue\n");
}

}  // namespace saccade
