#include "apps/sweep/sweep_coordinator.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <iterator>
#include <set>
#include <thread>
#include <utility>

#include "apps/sweep/sweep_run.h"
#include "core/error.h"
#include "evaluation/report/sweep_report.h"
#include "recording/output_file.h"
#include "session/interrupt.h"
#include "session/progress.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;
using SweepClock = std::chrono::steady_clock;

constexpr int rounds_without_progress = 3;

std::string bytes_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace

std::string duration_text(double s) {
  if (s < 100.0) return fmt::format("{:.0f} s", s);
  if (s < 6000.0) return fmt::format("{:.0f} min", s / 60.0);
  return fmt::format("{:.1f} h", s / 3600.0);
}

SweepCoordinator::SweepCoordinator(const SweepEngineConfig& engine, const SweepPlan& plan,
                                   const SweepFolder& sweep, bool retry, std::vector<std::string> task_flags)
    : plan_(plan),
      sweep_(sweep),
      task_flags_(std::move(task_flags)),
      engine_(make_engine(engine, sweep.path())) {
  std::set<std::string> seen;
  for (const PlannedRun& run : plan.runs) {
    if (!seen.insert(run.id).second) continue;
    const fs::path folder = sweep_.run(run.id);
    if (retry) fs::remove(folder / "failure.txt");
    if (sweep_.has_result(run.id)) continue;
    fs::create_directories(folder);
    // Not synced to the disk: the next start writes this file again.
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

/// Collects results until no run is in progress.
template <class Show>
void SweepCoordinator::wait(const Show& show) {
  for (bool busy = true; busy;) {
    busy = engine_->busy();
    const auto begin = SweepClock::now();
    collect();
    show();
    if (watch_) watch_(*this);
    const double cost_s = std::chrono::duration<double>(SweepClock::now() - begin).count();
    if (busy) pause(std::max(0.2, 20.0 * cost_s));
  }
}

void SweepCoordinator::make_missing_runs() {
  const std::size_t had = distinct_ - missing_.size();
  fmt::print(stderr, "{} runs, {} of them different; {} have a result\n", plan_.runs.size(), distinct_, had);
  Progress progress(static_cast<double>(missing_.size()));
  const std::size_t to_do = missing_.size();
  const auto begin = SweepClock::now();
  const auto show = [&] {
    const std::size_t done = to_do - missing_.size();
    if (done == 0) return;
    progress.show(static_cast<double>(done), [&] {
      const double elapsed_s = std::chrono::duration<double>(SweepClock::now() - begin).count();
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
    engine_->start(command(task_flags_), missing_);
    wait(show);
    idle_rounds = missing_.size() < before ? 0 : idle_rounds + 1;
    if (idle_rounds == rounds_without_progress) give_up();
  }
  progress.done();
}

void SweepCoordinator::make_worst_runs() {
  std::vector<std::string> ids;
  const SweepTable table = store_->table();
  for (const SweepRow* row : worst_runs(table)) {
    if (!sweep_.has_worst_report(row->id)) ids.push_back(row->id);
  }
  if (ids.empty()) return;
  fmt::print(stderr, "{} of the worst runs again, for their reports\n", ids.size());
  engine_->start(command({"--worst"}), ids);
  while (engine_->busy()) {
    if (watch_) watch_(*this);
    pause(0.2);
  }
  for (const std::string& id : ids) {
    std::error_code ignored;
    const fs::path log = sweep_.run(id) / "log.txt";
    if (sweep_.has_worst_report(id)) fs::remove(log, ignored);
  }
}

std::vector<std::string> SweepCoordinator::command(const std::vector<std::string>& flags) const {
  std::vector<std::string> words = {fs::read_symlink("/proc/self/exe").string(), "sweep-task"};
  words.insert(words.end(), flags.begin(), flags.end());
  words.push_back(sweep_.path().string());
  return words;
}

void SweepCoordinator::pause(double s) {
  std::this_thread::sleep_for(std::chrono::duration<double>(s));
  if (!interrupted()) return;
  engine_->stop();
  const std::string after = engine_->after_stop();
  throw RunError("interrupted; the same command goes on where it was" + (after.empty() ? "" : "; " + after));
}

void SweepCoordinator::collect() {
  const auto found = std::stable_partition(missing_.begin(), missing_.end(),
                                           [&](const std::string& id) { return !sweep_.has_result(id); });
  if (found == missing_.end()) return;
  store_->add({found, missing_.end()});
  missing_.erase(found, missing_.end());
}

std::ptrdiff_t SweepCoordinator::running() const {
  return std::count_if(missing_.begin(), missing_.end(),
                       [&](const std::string& id) { return sweep_.is_running(id); });
}

/// Several rounds of the engine brought no new result.
void SweepCoordinator::give_up() {
  constexpr std::uintmax_t little = 1 << 20;
  if (fs::space(sweep_.path()).available < little) {
    throw DiskFull(sweep_.path().string() + ": the disk is full");
  }
  for (const std::string& id : missing_) {
    write_file(sweep_.run(id) / "failure.txt",
               fmt::format("no result after {} attempts: it was killed or never started\n",
                           rounds_without_progress));
  }
  collect();
}

}  // namespace saccade
