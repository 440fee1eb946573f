#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "apps/sweep/sweep_folder.h"
#include "apps/sweep/sweep_plan.h"
#include "evaluation/report/sweep_report.h"

namespace SQLite {
class Database;
}

namespace saccade {

/// The table of a sweep, sweep.sqlite in its folder:
///
///     sweep(key, value)                     name, description, version, scenario, worst, worst_is
///     axes(number, key)                     from 0
///     report_metrics(number, name)          what the report shows, the main one first
///     runs(run, id, seed, status, failure)  status: waiting, done, failed; run counts from 1 in the plan's order
///     parameters(run, key, value)           each axis' value
///     metrics(run, name, value)             every number of metrics.json by its path, NULL where it does not apply
///     curves(run, detector, points)         [[threshold, precision, recall], ...]
///     times(run, name, value)               what depends on the clock: wall_s, ..., finished (seconds since 1970)
///
/// Except for `times` its contents do not depend on the engine, the order of the runs and the number of attempts. A member
/// throws DiskFull where there is no room for it, otherwise RunError when the file cannot be used.
class SweepStore {
 public:
  /// Writes the table again from the plan and the results in the folder.
  static void create(const SweepFolder& folder, const SweepPlan& plan);

  explicit SweepStore(const SweepFolder& folder);
  ~SweepStore();

  /// Adds the results of runs that have one.
  void add(const std::vector<std::string>& ids);

  [[nodiscard]] std::string name() const;
  /// Of all runs in their order, those that are the same as an earlier one included.
  [[nodiscard]] std::vector<std::string> ids() const;
  [[nodiscard]] std::int64_t count(const std::string& status) const;
  /// One row per run, in the plan's order; `times` adds the columns that depend on the clock.
  [[nodiscard]] std::string csv(bool times) const;
  /// The data of the report, and the folders of the reports of the worst runs.
  [[nodiscard]] SweepTable table() const;

 private:
  SweepFolder folder_;
  std::unique_ptr<SQLite::Database> database_;
};

}  // namespace saccade
