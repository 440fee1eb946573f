#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace saccade {

/// Where runs are made.
struct SweepEngineConfig {
  std::string engine =
      "local";                 ///< local: processes of this machine, by xargs; slurm: a job array, by sbatch
  std::int64_t jobs = 0;       ///< at the same time; 0: as many as there are processors, for slurm no limit
  std::int64_t batch = 0;      ///< runs in a row in one job or process; 0: as it is best
  std::string sbatch_options;  ///< further ones, separated by blanks
};

/// Throws InputError for an engine that does not exist or is not installed here, and for numbers out of range.
void check_engine(const SweepEngineConfig& config);

/// An engine of others that starts `saccade sweep-task FOLDER ID...` in many places.
class SweepEngine {
 public:
  virtual ~SweepEngine() = default;

  /// Starts the runs. `command` is a program and its first arguments. Throws RunError.
  virtual void start(const std::vector<std::string>& command, const std::vector<std::string>& ids) = 0;
  /// Whether it is still at work, or has been before this process was. Throws DiskFull where it stopped for that.
  [[nodiscard]] virtual bool busy() = 0;
  /// Ends what can be ended; what this machine runs is gone thereafter.
  virtual void stop() = 0;
  /// What the user should know when this process ends before the engine does; empty where nothing goes on.
  [[nodiscard]] virtual std::string after_stop() const = 0;
};

/// `folder` is the sweep's, absolute.
[[nodiscard]] std::unique_ptr<SweepEngine> make_engine(const SweepEngineConfig& config,
                                                       const std::filesystem::path& folder);

/// What sweep-task ends with when the disk is full; xargs then starts no more.
inline constexpr int stop_all_status = 255;

}  // namespace saccade
