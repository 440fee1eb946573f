#pragma once

#include <filesystem>
#include <vector>

#include "apps/sweep/scenario_tests.h"

namespace saccade {

/// Writes JUnit XML, as GitHub, GitLab and Jenkins read it: a `testsuite` for each scenario, a `testcase` for each of its
/// expectations (or one, `runs to its end`, where it has none). An expectation that is not met is a `failure`; after a
/// failed run each test case is an `error`. `time` is the wall-clock time of the run's process, s, in equal parts on its test
/// cases; 0 where it did not end. Throws RunError.
void write_junit(const std::filesystem::path& path, const std::vector<ScenarioTest>& tests);

}  // namespace saccade
