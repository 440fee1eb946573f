#include "apps/sweep/scenario_tests.h"

#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <thread>

#include "apps/sweep/child_process.h"
#include "apps/sweep/junit.h"
#include "apps/sweep/sweep_engine.h"
#include "apps/sweep/sweep_folder.h"
#include "apps/sweep/test_table.h"
#include "config/scenario.h"
#include "core/error.h"
#include "recording/file_lock.h"
#include "recording/number_text.h"
#include "recording/output_file.h"
#include "session/interrupt.h"
#include "session/run_scenario.h"
#include "session/scenario_loop.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;

/// Files of `saccade test` in its folder.
struct TestFolder {
  fs::path path;
  [[nodiscard]] fs::path run(const std::string& name) const { return path / name; }
  [[nodiscard]] fs::path tasks() const { return path / "tasks"; }
  [[nodiscard]] fs::path task(const std::string& name, const char* ending) const {
    return tasks() / (name + ending);
  }
  [[nodiscard]] bool is_over(const std::string& name) const {
    return fs::exists(task(name, ".done")) || fs::exists(task(name, ".failure"));
  }
};

/// Whether a test made the run in that folder: its scenario is the one that the test noted, or gave to its process.
bool is_of_a_test(const TestFolder& folder, const std::string& name) {
  const std::string run = text_of_file(folder.run(name) / "scenario.yaml");
  if (run.empty()) return false;
  const std::string after_versions = run.substr(std::min(run.find('\n'), run.size() - 1) + 1);
  return run == text_of_file(folder.task(name, ".made")) ||
         after_versions == text_of_file(folder.task(name, ".yaml"));
}

std::string unused_name(const std::string& name, const std::vector<ScenarioTest>& tests) {
  const auto used = [&](const std::string& wanted) {
    return wanted == "tasks" || std::ranges::any_of(tests, [&](const auto& t) { return t.name == wanted; });
  };
  std::string unused = name;
  for (int number = 2; used(unused); ++number) unused = fmt::format("{}-{}", name, number);
  return unused;
}

/// A test and the scenario as its process reads it.
struct PlannedTests {
  std::vector<ScenarioTest> tests;
  std::vector<std::string> yaml;  ///< of each
};

PlannedTests plan_tests(const ScenarioTestOptions& options, const Registry& registry) {
  PlannedTests plan;
  std::vector<Problem> problems;
  for (const fs::path& file : options.scenarios) {
    try {
      Scenario scenario = read_scenario(file, options.assignments, options.seed, registry);
      ScenarioTest test{.name = unused_name(scenario.name, plan.tests),
                        .file = file,
                        .seed = scenario.seed,
                        .expect = scenario.expect,
                        .failure = std::nullopt,
                        .judged = {}};
      const TestFolder tests{options.out};
      const fs::path folder = tests.run(test.name);
      if (!options.force && fs::exists(folder) && !(fs::is_directory(folder) && fs::is_empty(folder)) &&
          !is_of_a_test(tests, test.name))
        problems.push_back({folder.string(), "a folder that is not empty", "a new one, or --force"});
      // One thread for each run: the results do not depend on it.
      if (options.jobs != 1 && options.scenarios.size() > 1) scenario.run.threads = 1;
      plan.yaml.push_back(resolved_scenario(scenario));
      plan.tests.push_back(std::move(test));
    } catch (const InputError& error) {
      problems.insert(problems.end(), error.problems().begin(), error.problems().end());
    }
  }
  if (!problems.empty()) throw InputError(std::move(problems));
  return plan;
}

/// Reads what the test's run left.
void finish(ScenarioTest& test, const TestFolder& folder) {
  const fs::path metrics_file = folder.run(test.name) / "metrics.json";
  std::ifstream end(
      folder.task(test.name, fs::exists(folder.task(test.name, ".done")) ? ".done" : ".failure"));
  std::string elapsed;
  std::string why;
  std::getline(end, elapsed);
  std::getline(end, why);
  if (double elapsed_s = 0.0; parse_number(elapsed, elapsed_s)) test.elapsed_s = elapsed_s;
  if (!fs::exists(folder.task(test.name, ".done")) || !fs::exists(metrics_file)) {
    test.failure = why.empty() ? "no result: its process was killed" : why;
    return;
  }
  const Metrics metrics = read_metrics(metrics_file);
  if (metrics.interrupted) {
    test.failure = "interrupted";
    return;
  }
  test.wall_s = metrics.wall_s;
  test.judged = judge(test.expect, metrics);
}

/// Returns false after an interrupt; what is not over then has failed.
bool wait_for_runs(SweepEngine& engine, std::vector<ScenarioTest>& tests, const TestFolder& folder) {
  std::vector<bool> shown(tests.size(), false);
  const auto show = [&](std::size_t i) {
    shown[i] = true;
    fmt::print(stderr, "{}\n", test_line(tests[i]));
  };
  for (bool busy = true; busy;) {
    busy = engine.busy();
    for (std::size_t i = 0; i < tests.size(); ++i) {
      if (shown[i] || (busy && !folder.is_over(tests[i].name))) continue;
      finish(tests[i], folder);
      show(i);
    }
    if (busy) std::this_thread::sleep_for(std::chrono::milliseconds(100));
    if (!interrupted()) continue;
    engine.stop();
    for (std::size_t i = 0; i < tests.size(); ++i) {
      if (shown[i]) continue;
      finish(tests[i], folder);
      if (!folder.is_over(tests[i].name)) tests[i].failure = "interrupted";
      show(i);
    }
    return false;
  }
  return true;
}

/// Throws InputError where the file cannot be written, before the runs.
void check_junit(const fs::path& junit) {
  if (junit.empty()) return;
  std::error_code ignored;
  if (fs::is_directory(junit, ignored))
    throw InputError("--junit", junit.string() + ", a folder", "a file that can be written");
  try {
    const OutputFile probe(junit);
  } catch (const RunError& error) {
    throw InputError("--junit", error.what(), "a file that can be written");
  }
}

}  // namespace

int test_scenarios(const ScenarioTestOptions& options, const Registry& registry) {
  SweepEngineConfig config;
  config.jobs = options.jobs;
  config.batch = 1;
  check_engine(config);
  PlannedTests plan = plan_tests(options, registry);
  std::vector<ScenarioTest>& tests = plan.tests;
  const TestFolder folder{fs::weakly_canonical(fs::absolute(options.out))};
  std::error_code error;
  fs::create_directories(folder.tasks(), error);
  if (error) throw RunError(folder.tasks().string() + ": cannot make the folder: " + error.message());
  const FileLock lock(folder.tasks() / "lock");
  if (!lock.held())
    throw InputError(folder.path.string(), "a test at work in it", "another folder, or wait for its end");
  check_junit(options.junit);
  std::vector<std::string> names;
  for (std::size_t i = 0; i < tests.size(); ++i) {
    names.push_back(tests[i].name);
    for (const char* ending : {".log", ".done", ".failure"})
      fs::remove(folder.task(names.back(), ending), error);
    write_file(folder.task(tests[i].name, ".yaml"), plan.yaml[i]);
  }
  catch_interrupts();
  const auto engine = make_engine(config, folder.tasks());
  engine->start({fs::read_symlink("/proc/self/exe").string(), "test-task", folder.path.string()}, names);
  const bool whole = wait_for_runs(*engine, tests, folder);
  fs::remove(folder.tasks() / "batches.txt", error);
  for (const std::string& name : names) fs::remove(folder.task(name, ".done"), error);
  fmt::print("{}", test_table(tests));
  if (!options.junit.empty()) write_junit(options.junit, tests);
  if (!whole) throw RunError("interrupted; the table and the JUnit file hold what was over until then");
  const auto any = [&](const auto& condition) { return std::ranges::any_of(tests, condition); };
  if (any([](const ScenarioTest& test) { return test.failure.has_value(); })) return 1;
  return any([](const ScenarioTest& test) {
    return std::ranges::any_of(test.judged, [](const auto& judged) { return !judged.met(); });
  })
             ? 3
             : 0;
}

int make_test_runs(const TestTaskOptions& options, const Registry& registry) {
  const TestFolder folder{options.folder};
  die_with_parent(::getppid());
  for (const std::string& name : options.names) {
    const FileLock log(folder.task(name, ".log"));
    if (::ftruncate(log.file(), 0) != 0)
      throw RunError(folder.task(name, ".log").string() + ": cannot be written");
    const auto begin = std::chrono::steady_clock::now();
    const ChildEnd end = run_in_child(log.file(), [&] {
      const Scenario scenario = read_scenario(folder.task(name, ".yaml"), {}, std::nullopt, registry);
      set_rasterisers(scenario.run.threads);
      run_scenario(scenario,
                   {.folder = folder.run(name), .force = true, .assignments = {}, .show = {}, .close = {}});
      return 0;
    });
    const double elapsed_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    if (const std::string made = text_of_file(folder.run(name) / "scenario.yaml"); !made.empty())
      write_file(folder.task(name, ".made"), made);
    const bool done = WIFEXITED(end.status) && WEXITSTATUS(end.status) == 0;
    const std::string why = done ? "" : failure_text(end, folder.task(name, ".log")) + "\n";
    write_file(folder.task(name, done ? ".done" : ".failure"), fmt::format("{:.3f}\n{}", elapsed_s, why));
  }
  return 0;
}

}  // namespace saccade
