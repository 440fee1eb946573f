#include "apps/sweep/sweep_task.h"

#include <fmt/format.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>

#include "apps/config/scenario.h"
#include "apps/session/run_scenario.h"
#include "apps/session/scenario_loop.h"
#include "apps/sweep/sweep_engine.h"
#include "apps/sweep/sweep_folder.h"
#include "core/error.h"
#include "evaluation/scoring/metrics.h"
#include "recording/output_file.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;

constexpr int disk_full_status = 75;  ///< of the process that makes a run

/// Makes the run in `folder`/scenario.yaml and leaves `folder`/metrics.json.
void make_run(const fs::path& folder, const Registry& registry) {
  const Scenario scenario = read_scenario(folder / "scenario.yaml", {}, std::nullopt, registry);
  set_rasterisers(scenario.run.threads);
  write_metrics(folder / "metrics.json", score_scenario(scenario));
}

/// The last line of a run's log.
std::string last_line(const fs::path& log) {
  std::ifstream file(log);
  std::string last;
  for (std::string line; std::getline(file, line);)
    if (!line.empty()) last = line;
  return last;
}

/// Makes a run in its own process. Returns the exit status of that process.
int run_in_child(const fs::path& folder, const Registry& registry) {
  try {
    make_run(folder, registry);
    return 0;
  } catch (const DiskFull& error) {
    fmt::print(stderr, "{}\n", error.what());
    return disk_full_status;
  } catch (const InputError& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
}

/// Ends this process when its parent process ends.
void die_with_parent(pid_t parent) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(1);
}

/// Whether the process was ended by a signal, which is not a failure of the run.
bool was_killed(int signal_number) {
  return signal_number == SIGKILL || signal_number == SIGTERM || signal_number == SIGINT ||
         signal_number == SIGHUP;
}

/// Makes a run in a process of its own, unless it has a result or another process makes it; notes a failure.
/// Throws DiskFull.
void make_run_in_process(const SweepFolder& sweep, const std::string& id, const Registry& registry) {
  const fs::path folder = sweep.run(id);
  if (sweep.has_result(id)) return;
  const fs::path log = folder / "log.txt";
  const FileLock lock(log);
  if (!lock.held() || sweep.has_result(id)) return;
  if (::ftruncate(lock.file(), 0) != 0) throw RunError(log.string() + ": cannot be written");
  std::fflush(nullptr);
  const pid_t parent = ::getpid();
  const pid_t child = ::fork();
  if (child < 0) throw RunError(std::string("cannot start a process: ") + std::strerror(errno));
  if (child == 0) {
    die_with_parent(parent);
    ::dup2(lock.file(), STDOUT_FILENO);
    ::dup2(lock.file(), STDERR_FILENO);
    const int status = run_in_child(folder, registry);
    std::fflush(nullptr);
    ::_exit(status);
  }
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) {
    if (fs::file_size(log) == 0) fs::remove(log);
    return;
  }
  if (WIFEXITED(status) && WEXITSTATUS(status) == disk_full_status) throw DiskFull(last_line(log));
  if (WIFSIGNALED(status) && was_killed(WTERMSIG(status))) return;
  std::string why = last_line(log);
  if (WIFSIGNALED(status)) why = fmt::format("ended by signal {}: {}", WTERMSIG(status), why);
  OutputFile failure(folder / "failure.txt");
  failure.write(why + "\n");
  failure.commit();
}

/// Makes a run once more, as `saccade run` does, with pictures and a report.
void make_worst(const SweepFolder& sweep, const std::string& id, const std::string& program) {
  const fs::path folder = sweep.worst(id);
  if (fs::exists(folder / "report.html")) return;
  fs::create_directories(folder);
  const FileLock lock(sweep.run(id) / "log.txt");
  if (!lock.held()) return;
  const pid_t parent = ::getpid();
  const pid_t child = ::fork();
  if (child == 0) {
    die_with_parent(parent);
    ::dup2(lock.file(), STDOUT_FILENO);
    ::dup2(lock.file(), STDERR_FILENO);
    const std::string scenario = (sweep.run(id) / "scenario.yaml").string();
    ::execl(program.c_str(), program.c_str(), "run", scenario.c_str(), "--set", "output.pictures=10",
            "--force", "--out", folder.c_str(), static_cast<char*>(nullptr));
    ::_exit(127);
  }
  ::waitpid(child, nullptr, 0);
}

}  // namespace

int make_sweep_runs(const SweepTaskOptions& options, const Registry& registry) {
  const SweepFolder sweep(options.folder);
  die_with_parent(::getppid());
  try {
    for (const std::string& id : options.ids) {
      if (options.worst) {
        make_worst(sweep, id, fs::read_symlink("/proc/self/exe").string());
      } else {
        make_run_in_process(sweep, id, registry);
      }
    }
  } catch (const DiskFull& error) {
    fmt::print(stderr, "saccade: {}\n", error.what());
    return stop_all_status;
  }
  return 0;
}

}  // namespace saccade
