#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "config/expectations.h"
#include "config/registry.h"

namespace saccade {

/// How test_scenarios() runs.
struct ScenarioTestOptions {
  std::vector<std::filesystem::path> scenarios;
  std::filesystem::path out = "runs";    ///< folder of the run folders
  std::filesystem::path junit;           ///< JUnit XML is written here; empty: no
  std::vector<std::string> assignments;  ///< overrides of every scenario
  std::optional<std::int64_t> seed;      ///< of every scenario
  std::int64_t jobs = 0;                 ///< runs at the same time; 0: one per processor
  bool force = false;                    ///< replace runs that no test made
};

/// A scenario, its run and what the run made of `expect`.
struct ScenarioTest {
  std::string name;  ///< of the run folder: the scenario's name, with a number where several have it
  std::filesystem::path file;  ///< of the scenario
  std::int64_t seed = 0;
  std::vector<Expectation> expect;
  // Once the run is over:
  std::optional<std::string> failure;     ///< why the run has no metrics
  std::vector<JudgedExpectation> judged;  ///< empty after a failure
  std::optional<double> wall_s = {};      ///< computing time of the run's loop
  std::optional<double> elapsed_s = {};   ///< of its process, from start to end
};

/// Runs scenarios, several at once, each in a process of its own and into `out`/NAME; prints a table of what their
/// expectations came to. Layout of `out`: NAME/ run folders; tasks/ what the processes read (NAME.yaml) and printed
/// (NAME.log), and the scenario of the run folder that they made (NAME.made). Run folders that a test made are replaced.
/// Returns the exit status: 0 every expectation is met, 3 one is not, 1 a run failed.
/// Throws InputError with the problems of all scenarios before anything runs; RunError after an interrupt, when table and
/// JUnit file are written.
int test_scenarios(const ScenarioTestOptions& options, const Registry& registry);

/// Which runs make_test_runs() makes.
struct TestTaskOptions {
  std::filesystem::path folder;  ///< `out` of the test
  std::vector<std::string> names;
};

/// Makes runs of test_scenarios(); a failed one leaves tasks/NAME.failure. Returns 0.
int make_test_runs(const TestTaskOptions& options, const Registry& registry);

}  // namespace saccade
