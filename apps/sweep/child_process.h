#pragma once

#include <sys/types.h>

#include <filesystem>
#include <functional>

namespace saccade::inline v0_1 {

/// Processes that make one run each, so that a crash ends one run alone.

inline constexpr int disk_full_status = 75;  ///< exit status of a child whose work threw DiskFull

/// Kills this process when its parent process ends.
void die_with_parent(pid_t parent);

/// Runs `work` in a child process, standard output and error in the open file `log`. The child's exit status is what `work`
/// returns; for an exception its message is in the log and the status is 2 (InputError), disk_full_status or 1. Returns
/// the child's status as waitpid() gives it. Throws RunError where no process can be started.
int run_in_child(int log, const std::function<int()>& work);

/// Whether the status is that of a process which a user or the machine ended: no failure of the run.
[[nodiscard]] bool was_stopped(int status);

/// Why a process ended as it did: the last line of its log, and the signal where one ended it.
[[nodiscard]] std::string failure_text(int status, const std::filesystem::path& log);

}  // namespace saccade::inline v0_1
