#include "apps/sweep/scenario_tests.h"

#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <iterator>
#include <thread>

#include "apps/config/scenario.h"
#include "apps/session/interrupt.h"
#include "apps/session/run_scenario.h"
#include "apps/session/scenario_loop.h"
#include "apps/sweep/child_process.h"
#include "apps/sweep/junit.h"
#include "apps/sweep/sweep_engine.h"
#include "apps/sweep/sweep_folder.h"
#include "apps/sweep/test_table.h"
#include "core/error.h"
#include "recording/output_file.h"

namespace saccade::inline v0_1 {
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
                        .judged = {},
                        .wall_s = std::nullopt};
      const fs::path folder = options.out / test.name;
      if (!options.force && fs::exists(folder) && !(fs::is_directory(folder) && fs::is_empty(folder)))
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

std::string text_of_file(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Reads what the test's run left.
void finish(ScenarioTest& test, const TestFolder& folder) {
  const fs::path metrics_file = folder.run(test.name) / "metrics.json";
  const fs::path failure = folder.task(test.name, ".failure");
  if (!fs::exists(folder.task(test.name, ".done")) || !fs::exists(metrics_file)) {
    std::string why = fs::exists(failure) ? text_of_file(failure) : "no result: its process was killed";
    why.erase(std::find(why.begin(), why.end(), '\n'), why.end());
    test.failure = why;
    return;
  }
  const Metrics metrics = read_metrics(metrics_file);
  test.wall_s = metrics.wall_s;
  test.judged = judge(test.expect, metrics);
}

void wait_for_runs(SweepEngine& engine, std::vector<ScenarioTest>& tests, const TestFolder& folder) {
  std::vector<bool> shown(tests.size(), false);
  for (bool busy = true; busy;) {
    busy = engine.busy();
    for (std::size_t i = 0; i < tests.size(); ++i) {
      if (shown[i] || (busy && !folder.is_over(tests[i].name))) continue;
      shown[i] = true;
      finish(tests[i], folder);
      fmt::print(stderr, "{}\n", test_line(tests[i]));
    }
    if (busy) std::this_thread::sleep_for(std::chrono::milliseconds(100));
    if (!interrupted()) continue;
    engine.stop();
    throw RunError("interrupted; the run folders hold what happened until then");
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
  wait_for_runs(*engine, tests, folder);
  fs::remove(folder.tasks() / "batches.txt", error);
  for (const std::string& name : names) fs::remove(folder.task(name, ".done"), error);
  fmt::print("{}", test_table(tests));
  if (!options.junit.empty()) write_junit(options.junit, tests);
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
    const int status = run_in_child(log.file(), [&] {
      const Scenario scenario = read_scenario(folder.task(name, ".yaml"), {}, std::nullopt, registry);
      set_rasterisers(scenario.run.threads);
      run_scenario(scenario,
                   {.folder = folder.run(name), .force = true, .assignments = {}, .show = {}, .close = {}});
      return 0;
    });
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) {
      write_file(folder.task(name, ".done"), "");
    } else {
      write_file(folder.task(name, ".failure"), failure_text(status, folder.task(name, ".log")) + "\n");
    }
  }
  return 0;
}

}  // namespace saccade::inline v0_1
