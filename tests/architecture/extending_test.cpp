// Code blocks of docs/extending.md are the files of examples/ that they name.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>
#include <string>

namespace saccade {
namespace {

namespace fs = std::filesystem;

const fs::path root = SACCADE_SOURCE_DIR;

std::string text_of_file(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

TEST(Extending, EveryCodeBlockWithAFileNameIsThatFile) {
  const std::string document = text_of_file(root / "docs/extending.md");
  const std::regex marker("<!-- file: ([^ ]+) -->\n```[a-z]+\n");
  std::set<std::string> shown;
  for (std::sregex_iterator it(document.begin(), document.end(), marker), end; it != end; ++it) {
    const std::string path = (*it)[1];
    const auto begin = static_cast<std::size_t>(it->position() + it->length());
    const std::string block = document.substr(begin, document.find("```\n", begin) - begin);
    ASSERT_TRUE(fs::exists(root / path)) << path;
    EXPECT_EQ(block, text_of_file(root / path)) << path;
    shown.insert(path);
  }
  EXPECT_TRUE(shown.contains("examples/detector/main.cpp"));
}

}  // namespace
}  // namespace saccade
