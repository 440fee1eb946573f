#pragma once

#include <spawn.h>
#include <sys/types.h>

#include <string>
#include <vector>

namespace saccade {

/// How posix_spawn starts a program of ours: with default signals, and with no open file of this process but standard error
/// and what the members add. posix_spawn is safe beside other threads, unlike fork.
class SpawnSettings {
 public:
  SpawnSettings();
  SpawnSettings(const SpawnSettings&) = delete;
  SpawnSettings& operator=(const SpawnSettings&) = delete;
  ~SpawnSettings();

  /// The program's file `number` (0 standard input, 1 standard output) is `descriptor` of this process.
  void use(int descriptor, int number);
  /// The program's file `number` is /dev/null.
  void use_nothing(int number);
  /// The program runs in a process group of its own: an interrupt from the keyboard does not reach it.
  void own_process_group();
  /// The program's working directory.
  void work_in(const std::string& folder);

  /// Starts `words`, the program and its arguments; a name without a slash is searched in PATH. Returns 0, or the error's
  /// number. Called once.
  [[nodiscard]] int start(std::vector<std::string> words, pid_t& child);

 private:
  posix_spawn_file_actions_t files_;
  posix_spawnattr_t attributes_;
};

}  // namespace saccade
