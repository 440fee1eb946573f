#include "evaluation/report/gnuplot_process.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <sstream>
#include <string_view>
#include <vector>

#include "core/error.h"

namespace saccade {
namespace {

using File = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;

File temporary_file() {
  File file(std::tmpfile(), &std::fclose);
  if (!file) throw RunError(std::string("figures: no temporary file: ") + std::strerror(errno));
  return file;
}

std::string contents(std::FILE* file) {
  std::string text;
  std::rewind(file);
  char buffer[65536];
  for (std::size_t n = 0; (n = std::fread(buffer, 1, sizeof buffer, file)) > 0;) text.append(buffer, n);
  return text;
}

std::vector<char*> environment_with(std::string& setting) {
  const std::string_view key = std::string_view(setting).substr(0, setting.find('=') + 1);
  std::vector<char*> environment;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    if (!std::string_view(*entry).starts_with(key)) environment.push_back(*entry);
  }
  environment.push_back(setting.data());
  environment.push_back(nullptr);
  return environment;
}

}  // namespace

bool gnuplot_installed() {
  const char* const path = std::getenv("PATH");
  std::istringstream folders(path != nullptr ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');) {
    if (!folder.empty() && ::access((folder + "/gnuplot").c_str(), X_OK) == 0) return true;
  }
  return false;
}

// Files instead of pipes: neither side can wait for the other.
std::string run_gnuplot(const std::string& script) {
  const File in = temporary_file();
  const File out = temporary_file();
  const File err = temporary_file();
  if (std::fwrite(script.data(), 1, script.size(), in.get()) != script.size() || std::fflush(in.get()) != 0) {
    throw RunError(std::string("figures: cannot write a temporary file: ") + std::strerror(errno));
  }
  std::rewind(in.get());

  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, fileno(in.get()), STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, fileno(out.get()), STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, fileno(err.get()), STDERR_FILENO);
  std::string program = "gnuplot";
  std::string no_user_settings = "--default-settings";
  std::string read_in_blocks = "/dev/stdin";  // without a name it reads its input byte by byte
  char* arguments[] = {program.data(), no_user_settings.data(), read_in_blocks.data(), nullptr};
  std::string locale = "LC_ALL=C";
  pid_t child = 0;
  const int failure =
      posix_spawnp(&child, "gnuplot", &actions, nullptr, arguments, environment_with(locale).data());
  posix_spawn_file_actions_destroy(&actions);
  if (failure == ENOENT) {
    throw RunError("figures: gnuplot is not installed (Debian package gnuplot-nox)");
  }
  if (failure != 0) throw RunError(std::string("figures: cannot start gnuplot: ") + std::strerror(failure));

  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  std::string drawing = contents(out.get());
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0 || drawing.empty()) {
    throw RunError("figures: gnuplot failed: " + contents(err.get()));
  }
  return drawing;
}

}  // namespace saccade
