#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "apps/sweep/sweep_engine.h"
#include "apps/sweep/sweep_folder.h"
#include "apps/sweep/sweep_plan.h"
#include "apps/sweep/sweep_store.h"

namespace saccade {

/// Starts the missing runs of a sweep and collects their results into its table, which only this process writes.
class SweepCoordinator {
 public:
  /// Writes a scenario for each missing run, and the table. `retry`: failed runs count as missing; `task_flags`: of the
  /// command sweep-task. `plan` outlives it. Throws DiskFull, RunError.
  SweepCoordinator(const SweepEngineConfig& engine, const SweepPlan& plan, const SweepFolder& sweep,
                   bool retry, std::vector<std::string> task_flags = {});

  [[nodiscard]] SweepStore& store() const { return *store_; }

  /// Called about every 0.2 s while runs are made, the worst ones too.
  void set_watch(std::function<void(const SweepCoordinator&)> watch) { watch_ = std::move(watch); }
  /// How many runs have no result, and how many are at work.
  [[nodiscard]] std::size_t missing() const { return missing_.size(); }
  [[nodiscard]] std::ptrdiff_t running() const;

  /// Throws RunError after an interrupt, DiskFull.
  void make_missing_runs();
  /// Makes the worst runs again, with pictures, for their reports. Ignores failures.
  void make_worst_runs();

 private:
  [[nodiscard]] std::vector<std::string> command(const std::vector<std::string>& flags) const;
  void pause(double s);
  template <class Show>
  void wait(const Show& show);
  void collect();
  void give_up();

  const SweepPlan& plan_;
  SweepFolder sweep_;
  std::vector<std::string> task_flags_;
  std::unique_ptr<SweepEngine> engine_;
  std::unique_ptr<SweepStore> store_;
  std::vector<std::string> missing_;
  std::size_t distinct_ = 0;
  std::function<void(const SweepCoordinator&)> watch_;
};

}  // namespace saccade
