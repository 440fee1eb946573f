#include "apps/sweep/sweep_engine.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <optional>
#include <thread>

#include "core/error.h"
#include "recording/file_digest.h"
#include "recording/output_file.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;

/// The ids in lines of `size_at(remaining)` each.
template <class Size>
void write_batches(const fs::path& path, const std::vector<std::string>& ids, const Size& size_at) {
  OutputFile file(path);
  for (std::size_t i = 0; i < ids.size();) {
    const std::size_t end = std::min(i + std::max<std::size_t>(size_at(ids.size() - i), 1), ids.size());
    for (; i < end; ++i) file.write(ids[i] + (i + 1 < end ? " " : "\n"));
  }
  file.commit();
}

/// Starting the program takes longer (0.15 s) than forking for a run, so a process gets several runs; fewer towards the end,
/// so that all processors end at about the same time.
class LocalEngine final : public SweepEngine {
 public:
  LocalEngine(const SweepEngineConfig& config, fs::path folder)
      : config_(config), folder_(std::move(folder)) {}
  LocalEngine(const LocalEngine&) = delete;
  LocalEngine& operator=(const LocalEngine&) = delete;
  ~LocalEngine() override { LocalEngine::stop(); }

  void start(const std::vector<std::string>& command, const std::vector<std::string>& ids) override {
    if (child_ != 0) ::waitpid(child_, nullptr, 0);  // its last run is over, or soon will be
    const auto jobs = static_cast<std::size_t>(config_.jobs);
    constexpr std::size_t most = 16;
    write_batches(folder_ / "batches.txt", ids, [&](std::size_t remaining) {
      return config_.batch > 0 ? static_cast<std::size_t>(config_.batch)
                               : std::min(remaining / (4 * jobs), most);
    });
    std::vector<std::string> words = {
        "xargs", "-P", std::to_string(jobs), "-L", "1", "-a", (folder_ / "batches.txt").string()};
    words.insert(words.end(), command.begin(), command.end());
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    const pid_t parent = ::getpid();
    child_ = ::fork();
    if (child_ < 0) throw RunError(std::string("cannot start xargs: ") + std::strerror(errno));
    if (child_ == 0) {
      // xargs, and with it every run, ends when this process does.
      ::prctl(PR_SET_PDEATHSIG, SIGTERM);
      if (::getppid() != parent) ::_exit(1);
      ::execvp("xargs", arguments.data());
      ::_exit(127);
    }
  }

  bool busy() override {
    if (child_ == 0) return false;
    int status = 0;
    if (::waitpid(child_, &status, WNOHANG) == 0) return true;
    child_ = 0;
    constexpr int a_run_said_255 = 124;
    if (WIFEXITED(status) && WEXITSTATUS(status) == a_run_said_255)
      throw DiskFull(folder_.string() + ": the disk is full");
    if (WIFEXITED(status) && WEXITSTATUS(status) == 127)
      throw RunError("xargs is not installed (Debian package findutils)");
    return false;
  }

  void stop() override {
    if (child_ == 0) return;
    ::kill(child_, SIGTERM);
    ::waitpid(child_, nullptr, 0);
    child_ = 0;
  }

  [[nodiscard]] std::string after_stop() const override { return {}; }

 private:
  SweepEngineConfig config_;
  fs::path folder_;
  pid_t child_ = 0;
};

std::string shell_quoted(const std::string& text) {
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? "'\\''" : std::string(1, c);
  return quoted + "'";
}

/// The output of a shell command; none if it fails.
std::optional<std::string> output_of(const std::string& command, std::string* error = nullptr) {
  FILE* const pipe = ::popen((command + " 2>&1").c_str(), "r");
  if (pipe == nullptr) return std::nullopt;
  std::string text;
  char buffer[4096];
  for (std::size_t n = 0; (n = std::fread(buffer, 1, sizeof buffer, pipe)) > 0;) text.append(buffer, n);
  while (text.ends_with('\n')) text.pop_back();
  if (::pclose(pipe) == 0) return text;
  if (error != nullptr) *error = text;
  return std::nullopt;
}

/// The array is found by its name, so no state is kept between two starts of this program.
class SlurmEngine final : public SweepEngine {
 public:
  SlurmEngine(const SweepEngineConfig& config, fs::path folder)
      : config_(config), folder_(std::move(folder)), job_("saccade-" + digest(folder_.string())) {}

  void start(const std::vector<std::string>& command, const std::vector<std::string>& ids) override {
    constexpr std::size_t most_tasks = 1000;  // MaxArraySize is 1001 where nobody has changed it
    const std::size_t batch = config_.batch > 0 ? static_cast<std::size_t>(config_.batch)
                                                : (ids.size() + most_tasks - 1) / most_tasks;
    const fs::path list = folder_ / "batches.txt";
    write_batches(list, ids, [&](std::size_t) { return batch; });
    std::string words;
    for (const std::string& word : command) words += shell_quoted(word) + " ";
    OutputFile script(folder_ / "slurm.sh");
    script.write(fmt::format("#!/bin/sh\nexec {}$(sed -n \"$((SLURM_ARRAY_TASK_ID + 1))p\" {})\n", words,
                             shell_quoted(list.string())));
    script.commit();
    const std::size_t tasks = (ids.size() + batch - 1) / batch;
    const std::string throttle = config_.jobs > 0 ? fmt::format("%{}", config_.jobs) : "";
    const std::string log = (folder_ / "slurm.log").string();
    std::string said;
    if (!output_of(fmt::format("sbatch --parsable --job-name={} --array=0-{}{} --requeue --open-mode=append "
                               "--output={} --error={} --chdir={} {} {}",
                               job_, tasks - 1, throttle, shell_quoted(log), shell_quoted(log),
                               shell_quoted(folder_.string()), config_.sbatch_options,
                               shell_quoted((folder_ / "slurm.sh").string())),
                   &said)) {
      throw RunError("sbatch: " + said);
    }
    asked_ = {};
  }

  bool busy() override {
    const auto now = std::chrono::steady_clock::now();
    if (asked_ && now - *asked_ < std::chrono::seconds(1)) return busy_;
    asked_ = now;
    // Without an answer of the controller the state of the jobs is unknown.
    if (const auto jobs = output_of("squeue --me --noheader --format=%i --name=" + job_))
      busy_ = !jobs->empty();
    return busy_;
  }

  void stop() override {}

  [[nodiscard]] std::string after_stop() const override {
    return "the array goes on; `scancel --name=" + job_ + "` ends it";
  }

 private:
  SweepEngineConfig config_;
  fs::path folder_;
  std::string job_;
  std::optional<std::chrono::steady_clock::time_point> asked_;
  bool busy_ = true;
};

bool is_installed(const std::string& program) { return output_of("command -v " + program).has_value(); }

}  // namespace

void check_engine(const SweepEngineConfig& config) {
  std::vector<Problem> problems;
  if (config.engine != "local" && config.engine != "slurm") {
    problems.push_back({"--engine", config.engine, "one of local, slurm"});
  } else if (config.engine == "slurm" && !(is_installed("sbatch") && is_installed("squeue"))) {
    problems.push_back({"--engine", "slurm, but no sbatch and squeue", "Slurm's commands on this machine"});
  } else if (config.engine == "local" && !is_installed("xargs")) {
    problems.push_back({"--engine", "local, but no xargs", "the Debian package findutils"});
  }
  if (config.engine != "slurm" && !config.sbatch_options.empty()) {
    problems.push_back({"--sbatch", config.sbatch_options, "--engine slurm with it"});
  }
  if (!problems.empty()) throw InputError(std::move(problems));
}

std::unique_ptr<SweepEngine> make_engine(const SweepEngineConfig& config, const fs::path& folder) {
  if (config.engine == "slurm") return std::make_unique<SlurmEngine>(config, folder);
  SweepEngineConfig local = config;
  if (local.jobs == 0) local.jobs = std::max(1U, std::thread::hardware_concurrency());
  return std::make_unique<LocalEngine>(local, folder);
}

}  // namespace saccade
