#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace saccade {

/// Layout of a sweep's folder:
///
///     sweep.sqlite            the table: SweepStore
///     report.html, figures/   the report
///     worst/ID/               run folders of the worst runs
///     runs/ID/scenario.yaml   the resolved scenario of a run
///     runs/ID/benchmark.json  figures for the benchmark alone
///     runs/ID/dataset.json    of a data set: the files that it keeps of the run, beside it
///     runs/ID/metrics.json    its result, when it is done,
///     runs/ID/failure.txt     or why there is none
///     runs/ID/log.txt         its output; locked while it runs
///     lock                    locked while `saccade sweep` runs
///     batches.txt             the engine's list
///
/// The files in runs/ are the whole state of a sweep; the table is made from them.
class SweepFolder {
 public:
  explicit SweepFolder(std::filesystem::path path) : path_(std::move(path)) {}

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] std::filesystem::path table() const { return path_ / "sweep.sqlite"; }
  [[nodiscard]] std::filesystem::path run(const std::string& id) const { return path_ / "runs" / id; }
  [[nodiscard]] std::filesystem::path worst(const std::string& id) const { return path_ / "worst" / id; }

  /// Whether a run has finished or failed. One that was interrupted has not.
  [[nodiscard]] bool has_result(const std::string& id) const;
  /// When it finished or failed, by the file's time.
  [[nodiscard]] std::optional<std::filesystem::file_time_type> finished(const std::string& id) const;
  /// Whether its run folder among the worst is complete.
  [[nodiscard]] bool has_worst_report(const std::string& id) const;
  /// Whether a process makes it now.
  [[nodiscard]] bool is_running(const std::string& id) const;

 private:
  std::filesystem::path path_;
};

/// All of a small file; empty where it cannot be read.
[[nodiscard]] std::string text_of_file(const std::filesystem::path& path);

}  // namespace saccade
