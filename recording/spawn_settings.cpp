#include "recording/spawn_settings.h"

#include <fcntl.h>
#include <unistd.h>

#include <csignal>

namespace saccade {

SpawnSettings::SpawnSettings() {
  ::posix_spawn_file_actions_init(&files_);
  ::posix_spawnattr_init(&attributes_);
  sigset_t signals;
  sigemptyset(&signals);
  ::posix_spawnattr_setsigmask(&attributes_, &signals);
  sigfillset(&signals);
  ::posix_spawnattr_setsigdefault(&attributes_, &signals);
  ::posix_spawnattr_setflags(&attributes_, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
}

SpawnSettings::~SpawnSettings() {
  ::posix_spawnattr_destroy(&attributes_);
  ::posix_spawn_file_actions_destroy(&files_);
}

void SpawnSettings::use(int descriptor, int number) {
  ::posix_spawn_file_actions_adddup2(&files_, descriptor, number);
}

void SpawnSettings::use_nothing(int number) {
  ::posix_spawn_file_actions_addopen(&files_, number, "/dev/null",
                                     number == STDIN_FILENO ? O_RDONLY : O_WRONLY, 0);
}

void SpawnSettings::own_process_group() {
  ::posix_spawnattr_setpgroup(&attributes_, 0);
  short flags = 0;
  ::posix_spawnattr_getflags(&attributes_, &flags);
  ::posix_spawnattr_setflags(&attributes_, static_cast<short>(flags | POSIX_SPAWN_SETPGROUP));
}

void SpawnSettings::work_in(const std::string& folder) {
  ::posix_spawn_file_actions_addchdir_np(&files_, folder.c_str());
}

int SpawnSettings::start(std::vector<std::string> words, pid_t& child) {
  // Files are changed in the order of the calls: this one comes last.
  ::posix_spawn_file_actions_addclosefrom_np(&files_, STDERR_FILENO + 1);
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  return ::posix_spawnp(&child, argv[0], &files_, &attributes_, argv.data(), environ);
}

}  // namespace saccade
