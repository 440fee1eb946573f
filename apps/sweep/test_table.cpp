#include "apps/sweep/test_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace saccade {
namespace {

std::ptrdiff_t met_count(const ScenarioTest& test) {
  return std::ranges::count_if(test.judged, [](const JudgedExpectation& j) { return j.met(); });
}

using TestRow = std::array<std::string, 5>;

std::string aligned(const std::vector<TestRow>& rows) {
  std::array<std::size_t, 5> widths{};
  for (const TestRow& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  std::string text;
  for (const TestRow& row : rows) {
    std::string line = fmt::format("{:{}}  {:{}}  {:>{}}  {:{}}  {}", row[0], widths[0], row[1], widths[1],
                                   row[2], widths[2], row[3], widths[3], row[4]);
    text += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
  }
  return text;
}

}  // namespace

std::string test_line(const ScenarioTest& test) {
  if (test.failure) return test.name + ": the run failed: " + *test.failure;
  std::string line = test.name + ": ";
  line += test.judged.empty() ? "ran to its end, expects nothing"
                              : fmt::format("{} of {} met", met_count(test), test.judged.size());
  if (test.wall_s) line += fmt::format(", {:.1f} s", *test.wall_s);
  return line;
}

std::string test_table(const std::vector<ScenarioTest>& tests) {
  std::vector<TestRow> rows = {{"scenario", "figure", "value", "expected", "result"}};
  std::ptrdiff_t expectations = 0;
  std::ptrdiff_t met = 0;
  std::ptrdiff_t failed = 0;
  for (const ScenarioTest& test : tests) {
    expectations += std::ssize(test.expect);
    met += met_count(test);
    failed += test.failure ? 1 : 0;
    if (test.failure) {
      rows.push_back({test.name, "", "", "", "RUN FAILED: " + *test.failure});
    } else if (test.judged.empty()) {
      rows.push_back({test.name, "", "", "", "ran to its end"});
    }
    for (const JudgedExpectation& j : test.judged) {
      rows.push_back({test.name, j.expectation.metric, j.value ? fmt::format("{:.4g}", *j.value) : "null",
                      j.expectation.text(), j.met() ? "met" : "NOT MET"});
    }
  }
  return aligned(rows) + fmt::format("{} scenario{}, {} expectation{}: {} met, {} not met; {} run{} failed\n",
                                     tests.size(), tests.size() == 1 ? "" : "s", expectations,
                                     expectations == 1 ? "" : "s", met, expectations - met, failed,
                                     failed == 1 ? "" : "s");
}

}  // namespace saccade
