// Every CTest has a time limit of its own: a test that hangs fails instead of stopping all others.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace saccade {
namespace {

namespace fs = std::filesystem;

using testing::ElementsAre;
using testing::IsEmpty;

/// The rest of each call of `command`, up to its last bracket.
std::vector<std::string> arguments(const std::string& text, const std::string& command) {
  std::vector<std::string> found;
  for (std::size_t at = text.find(command); at != std::string::npos; at = text.find(command, at)) {
    at += command.size();
    std::size_t end = at;
    for (int depth = 1; end < text.size() && depth > 0; ++end) {
      if (text[end] == '(') ++depth;
      if (text[end] == ')') --depth;
    }
    found.push_back(text.substr(at, end - at));
  }
  return found;
}

/// The first word: the name of the test.
std::string name_in(const std::string& text) {
  std::istringstream stream(text);
  std::string name;
  stream >> name;
  return name;
}

/// Names of tests that `add_test` adds and no `set_tests_properties` of the same file gives a TIMEOUT.
std::vector<std::string> without_limit(const std::string& text) {
  std::vector<std::string> names;
  for (const std::string& test : arguments(text, "add_test(NAME ")) {
    bool limited = false;
    for (const std::string& properties : arguments(text, "set_tests_properties("))
      limited |= name_in(properties) == name_in(test) && properties.find("TIMEOUT") != std::string::npos;
    if (!limited) names.push_back(name_in(test));
  }
  return names;
}

TEST(TimeLimits, EveryTestThatIsAddedHasOne) {
  std::size_t files = 0;
  for (const char* folder : {"tests", "examples"}) {
    for (const fs::directory_entry& entry :
         fs::recursive_directory_iterator(fs::path(SACCADE_SOURCE_DIR) / folder)) {
      if (entry.path().filename() != "CMakeLists.txt") continue;
      std::ostringstream text;
      text << std::ifstream(entry.path()).rdbuf();
      EXPECT_THAT(without_limit(text.str()), IsEmpty()) << entry.path();
      ++files;
    }
  }
  EXPECT_GT(files, 20U);
}

TEST(TimeLimits, EveryTestOfATestProgramHasOne) {
  std::ostringstream text;
  text << std::ifstream(fs::path(SACCADE_SOURCE_DIR) / "cmake/SaccadeTargets.cmake").rdbuf();
  const std::vector<std::string> calls = arguments(text.str(), "gtest_discover_tests(");
  ASSERT_EQ(calls.size(), 1U);
  EXPECT_NE(calls[0].find(" TIMEOUT "), std::string::npos);
}

TEST(TimeLimits, FindsATestWithoutOne) {
  EXPECT_THAT(without_limit("add_test(NAME a COMMAND $<TARGET_FILE:a> (1))\n"
                            "add_test(NAME b COMMAND b)\n"
                            "add_test(NAME c.${kind} COMMAND c)\n"
                            "set_tests_properties(b PROPERTIES LABELS slow)\n"
                            "set_tests_properties(c.${kind} PROPERTIES TIMEOUT 60)\n"),
              ElementsAre("a", "b"));
}

}  // namespace
}  // namespace saccade
