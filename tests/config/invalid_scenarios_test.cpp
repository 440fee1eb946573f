#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <ostream>
#include <string>
#include <vector>

#include "config/scenario.h"
#include "core/error.h"
#include "tests/config/built_in.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;

struct ScenarioFile {
  fs::path path;
  friend auto operator<=>(const ScenarioFile&, const ScenarioFile&) = default;
};

std::ostream& operator<<(std::ostream& out, const ScenarioFile& file) {
  return out << file.path.stem().string();
}

/// Whether a file is a sweep over another scenario.
bool is_sweep(const fs::path& path) {
  std::ifstream stream(path);
  for (std::string line; std::getline(stream, line);) {
    if (line.starts_with("scenario:")) return true;
  }
  return false;
}

std::vector<ScenarioFile> scenarios_in(const char* folder) {
  std::vector<ScenarioFile> files;
  for (const auto& file : fs::directory_iterator(fs::path(SACCADE_SOURCE_DIR) / folder)) {
    if (file.path().extension() == ".yaml" && !is_sweep(file.path())) files.push_back({file.path()});
  }
  std::sort(files.begin(), files.end());
  return files;
}

/// The messages that a file says it must give, one a line: `# expect: <part of the message>`.
std::vector<std::string> expected_messages(const fs::path& path) {
  constexpr std::string_view mark = "# expect: ";
  std::vector<std::string> messages;
  std::ifstream stream(path);
  for (std::string line; std::getline(stream, line) && line.starts_with(mark);) {
    messages.push_back(line.substr(mark.size()));
  }
  return messages;
}

class InvalidScenario : public testing::TestWithParam<ScenarioFile> {};

TEST_P(InvalidScenario, GivesTheMessagesItStatesAndNoOther) {
  const fs::path& path = GetParam().path;
  const std::vector<std::string> expected = expected_messages(path);
  ASSERT_FALSE(expected.empty()) << "no line `# expect: ...` at the top";
  try {
    static_cast<void>(read_scenario(path, {}, std::nullopt, built_in()));
    FAIL() << "was read without a complaint";
  } catch (const InputError& error) {
    ASSERT_EQ(error.problems().size(), expected.size()) << error.what();
    for (std::size_t i = 0; i < expected.size(); ++i) {
      EXPECT_THAT(error.problems()[i].text(), testing::StartsWith(path.string() + ":"));
      EXPECT_THAT(error.problems()[i].text(), testing::HasSubstr(expected[i]));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Scenarios, InvalidScenario, testing::ValuesIn(scenarios_in("scenarios/invalid")));

class ShippedScenario : public testing::TestWithParam<ScenarioFile> {};

TEST_P(ShippedScenario, IsReadAndItsResolvedFormReadsBackTheSame) {
  const Scenario scenario = read_scenario(GetParam().path, {}, std::nullopt, built_in());
  const std::string resolved = resolved_scenario(scenario);
  const fs::path copy = fs::path(testing::TempDir()) / ("resolved_" + GetParam().path.filename().string());
  std::ofstream(copy) << resolved;
  EXPECT_EQ(resolved_scenario(read_scenario(copy, {}, std::nullopt, built_in())), resolved);
  fs::remove(copy);
}

INSTANTIATE_TEST_SUITE_P(Scenarios, ShippedScenario, testing::ValuesIn(scenarios_in("scenarios")));

}  // namespace
}  // namespace saccade
