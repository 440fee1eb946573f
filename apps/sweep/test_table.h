#pragma once

#include <string>
#include <vector>

#include "apps/sweep/scenario_tests.h"

namespace saccade {

/// One line about a test that is over: "look_at_ball: 3 of 3 met, 4.2 s".
[[nodiscard]] std::string test_line(const ScenarioTest& test);

/// A line per expectation, columns aligned, and the counts: for a terminal.
[[nodiscard]] std::string test_table(const std::vector<ScenarioTest>& tests);

}  // namespace saccade
