#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace saccade {

/// The engine that makes the runs of a sweep, and its limits.
struct SweepEngineConfig {
  std::string engine =
      "local";                 ///< local: processes of this machine, by xargs; slurm: a job array, by sbatch
  std::int64_t jobs = 0;       ///< at the same time; 0: as many as there are processors, for slurm no limit
  std::int64_t batch = 0;      ///< runs in a row in one job or process; 0: chosen by the engine
  std::string sbatch_options;  ///< further ones, separated by blanks
};

/// Throws InputError for an unknown engine, one that is not installed, and numbers out of range.
void check_engine(const SweepEngineConfig& config);

/// Starts `saccade sweep-task FOLDER ID...` many times, on this machine (xargs) or a cluster (Slurm).
class SweepEngine {
 public:
  virtual ~SweepEngine() = default;

  /// Starts the runs. `command` is a program and its first arguments. Throws RunError.
  virtual void start(const std::vector<std::string>& command, const std::vector<std::string>& ids) = 0;
  /// Whether runs are in progress, also those that an earlier process started. Throws DiskFull if the engine stopped for it.
  [[nodiscard]] virtual bool busy() = 0;
  /// Cancels runs as far as possible; those on this machine have ended when it returns.
  virtual void stop() = 0;
  /// Message for the user if runs continue after this process; empty if none do.
  [[nodiscard]] virtual std::string after_stop() const = 0;
};

/// `folder`: of the sweep, absolute.
[[nodiscard]] std::unique_ptr<SweepEngine> make_engine(const SweepEngineConfig& config,
                                                       const std::filesystem::path& folder);

/// Exit status of sweep-task if the disk is full; xargs then starts no further runs.
inline constexpr int stop_all_status = 255;

}  // namespace saccade
