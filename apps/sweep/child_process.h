#pragma once

#include <sys/types.h>

#include <filesystem>
#include <functional>
#include <string>

namespace saccade {

/// Processes that make one run each, so that a crash ends one run alone.

inline constexpr int disk_full_status = 75;  ///< exit status of a child whose work threw DiskFull

/// Kills this process when its parent process ends.
void die_with_parent(pid_t parent);

/// How a child process ended.
struct ChildEnd {
  int status = 0;   ///< as waitpid() gives it
  std::string why;  ///< the message of the exception that ended its work; empty where none did
};

/// Runs `work` in a child process, standard output and error in the open file `log`. The child's exit status is what `work`
/// returns; for an exception its message is the last line of the log, and the status is 2 (InputError), disk_full_status
/// or 1. Throws RunError where no process can be started.
[[nodiscard]] ChildEnd run_in_child(int log, const std::function<int()>& work);

/// Whether the status is that of a process which a user or the machine ended: no failure of the run.
[[nodiscard]] bool was_stopped(int status);

/// Why a process ended as it did, on one line: the message of the exception, else the last line of its log, and the signal
/// where one ended it.
[[nodiscard]] std::string failure_text(const ChildEnd& end, const std::filesystem::path& log);

}  // namespace saccade
