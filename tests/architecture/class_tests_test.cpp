// Each class has a test that includes its header: holds headers_without_tests.txt.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace saccade {
namespace {

namespace fs = std::filesystem;
using testing::IsEmpty;

std::string text_of(const fs::path& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

bool is_source(const fs::path& path) { return path.extension() == ".h" || path.extension() == ".cpp"; }

/// The headers that the files of tests/ include.
std::set<std::string> included_by_tests(const fs::path& root) {
  std::set<std::string> headers;
  for (const auto& entry : fs::recursive_directory_iterator(root / "tests")) {
    if (!entry.is_regular_file() || !is_source(entry.path())) continue;
    std::istringstream lines(text_of(entry.path()));
    for (std::string line; std::getline(lines, line);) {
      constexpr std::string_view begin = "#include \"";
      if (line.starts_with(begin)) headers.insert(line.substr(begin.size(), line.rfind('"') - begin.size()));
    }
  }
  return headers;
}

/// Whether a header defines a class: "class Name", maybe with bases, and "{" before a ";".
bool defines_a_class(const std::string& header) {
  for (std::size_t at = 0; (at = header.find("class ", at)) != std::string::npos; ++at) {
    if (at > 0 && header[at - 1] != '\n') continue;
    const std::size_t end = header.find_first_of("{;", at);
    if (end != std::string::npos && header[end] == '{') return true;
  }
  return false;
}

/// Headers with a class, of the layers.
std::set<std::string> headers_with_classes(const fs::path& root) {
  std::set<std::string> headers;
  for (const auto& folder : fs::directory_iterator(root)) {
    const std::string name = folder.path().filename().string();
    if (!folder.is_directory() || name.starts_with('.') || name == "build" || name == "tests" ||
        name == "examples")
      continue;
    for (const auto& entry : fs::recursive_directory_iterator(folder.path())) {
      if (entry.path().extension() == ".h" && defines_a_class(text_of(entry.path())))
        headers.insert(fs::relative(entry.path(), root).generic_string());
    }
  }
  return headers;
}

/// Lines `path: reason`, without comments.
std::map<std::string, std::string> stated_exceptions(const fs::path& path) {
  std::map<std::string, std::string> exceptions;
  std::istringstream lines(text_of(path));
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || line.starts_with('#')) continue;
    const std::size_t colon = line.find(": ");
    exceptions[line.substr(0, colon)] = colon == std::string::npos ? "" : line.substr(colon + 2);
  }
  return exceptions;
}

TEST(ClassTests, EachClassHasATestThatIncludesItsHeaderOrAStatedReason) {
  const fs::path root = SACCADE_SOURCE_DIR;
  const std::set<std::string> included = included_by_tests(root);
  const std::set<std::string> headers = headers_with_classes(root);
  const auto exceptions = stated_exceptions(root / "tests/architecture/headers_without_tests.txt");
  std::vector<std::string> without_test, without_reason, stale;
  for (const std::string& header : headers) {
    if (!included.contains(header) && !exceptions.contains(header)) without_test.push_back(header);
  }
  for (const auto& [header, reason] : exceptions) {
    if (reason.empty()) without_reason.push_back(header);
    if (!headers.contains(header) || included.contains(header)) stale.push_back(header);
  }
  EXPECT_GT(headers.size(), 200U);
  EXPECT_THAT(without_test, IsEmpty()) << "a test of the class includes its header";
  EXPECT_THAT(without_reason, IsEmpty());
  EXPECT_THAT(stale, IsEmpty()) << "no longer exceptions: delete their lines";
}

}  // namespace
}  // namespace saccade
