// REUSE.toml names the licence of every tracked file, and CITATION.cff what an archive needs to give a release a DOI.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace saccade {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::MatchesRegex;

const fs::path tree = SACCADE_SOURCE_DIR;

std::string content_of(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

/// Path patterns of an annotation and its licence.
struct Annotation {
  std::vector<std::string> paths;
  std::string copyright;
  std::string licence;
};

/// The annotations of a REUSE.toml whose values are texts or lists of texts on one line.
std::vector<Annotation> annotations_of(const std::string& toml) {
  std::vector<Annotation> annotations;
  std::istringstream lines(toml);
  const std::regex assignment("([A-Za-z-]+) = (.*)");
  const std::regex text("\"([^\"]*)\"");
  for (std::string line; std::getline(lines, line);) {
    std::smatch parts;
    if (line == "[[annotations]]") {
      annotations.emplace_back();
    } else if (!annotations.empty() && std::regex_match(line, parts, assignment)) {
      const std::string value = parts[2];
      std::vector<std::string> values;
      for (std::sregex_iterator at(value.begin(), value.end(), text), end; at != end; ++at)
        values.push_back((*at)[1]);
      Annotation& annotation = annotations.back();
      if (parts[1] == "path") annotation.paths = values;
      if (parts[1] == "SPDX-FileCopyrightText") annotation.copyright = values.at(0);
      if (parts[1] == "SPDX-License-Identifier") annotation.licence = values.at(0);
    }
  }
  return annotations;
}

/// `*` is any text without a slash, `**` any text.
bool matches_pattern(const std::string& pattern, const std::string& path) {
  std::string regex;
  for (std::size_t i = 0; i < pattern.size(); ++i) {
    if (pattern[i] != '*') {
      regex += std::string("\\^$.|?+()[]{}").find(pattern[i]) == std::string::npos ? "" : "\\";
      regex += pattern[i];
    } else if (pattern.compare(i, 2, "**") == 0) {
      regex += ".*";
      ++i;
    } else {
      regex += "[^/]*";
    }
  }
  return std::regex_match(path, std::regex(regex));
}

/// The last annotation that matches.
const Annotation* annotation_for(const std::vector<Annotation>& annotations, const std::string& path) {
  const auto found = std::find_if(annotations.rbegin(), annotations.rend(), [&](const Annotation& row) {
    return std::ranges::any_of(row.paths,
                               [&](const auto& pattern) { return matches_pattern(pattern, path); });
  });
  return found == annotations.rend() ? nullptr : &*found;
}

/// Files that are often another's work: their annotation must name them more closely than `**` does.
bool is_asset(const std::string& path, const std::string& content) {
  static const std::set<std::string> kinds = {".png", ".jpg", ".jpeg", ".webp", ".gif", ".svg", ".obj",
                                              ".stl", ".dae", ".js",   ".cjs",  ".mjs", ".css", ".ttf"};
  return kinds.contains(fs::path(path).extension().string()) || content.find('\0') != std::string::npos;
}

/// What is wrong with the licence of a file; empty: nothing.
std::string licence_problem(const std::vector<Annotation>& annotations, const std::string& path,
                            const std::string& content) {
  const Annotation* const annotation = annotation_for(annotations, path);
  if (annotation == nullptr) return path + ": no annotation of REUSE.toml covers it";
  if (annotation->licence.empty() || annotation->copyright.empty())
    return path + ": its annotation has no licence or no copyright";
  const bool is_general = annotation->paths == std::vector<std::string>{"**"};
  if (is_general && is_asset(path, content)) return path + ": an asset or script that only ** covers";
  // \050 is the bracket, so that this file has no such line itself.
  const std::size_t notice = std::min(content.find("Copyright \050c) "), content.find("Copyright \050C) "));
  if (is_general && path != "LICENSE" && !path.starts_with("LICENSES/") && notice != std::string::npos)
    return path + ": " + content.substr(notice, content.find('\n', notice) - notice) +
           ", and only ** covers it";
  return {};
}

/// Tracked files; empty where there is no repository, as in an archive of the sources.
std::vector<std::string> tracked_files() {
  const std::string command = "git -c safe.directory='*' -C '" + tree.string() + "' ls-files 2>/dev/null";
  FILE* const pipe = ::popen(command.c_str(), "r");
  std::string text;
  for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) text += static_cast<char>(c);
  ::pclose(pipe);
  std::vector<std::string> files;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (fs::is_regular_file(tree / line)) files.push_back(line);
  }
  return files;
}

TEST(Licence, EveryTrackedFileHasOneAndAssetsAreNamed) {
  const std::vector<std::string> files = tracked_files();
  if (files.empty()) GTEST_SKIP() << "SKIPPED: " << tree << " is not a checkout of git";
  const std::vector<Annotation> annotations = annotations_of(content_of(tree / "REUSE.toml"));
  std::vector<std::string> problems;
  for (const std::string& file : files) {
    const std::string problem = licence_problem(annotations, file, content_of(tree / file));
    if (!problem.empty()) problems.push_back(problem);
  }
  EXPECT_THAT(problems, IsEmpty());
  EXPECT_GT(files.size(), 1000U);
}

TEST(Licence, EachAnnotationOfREUSEtomlMatchesAFile) {
  const std::vector<std::string> files = tracked_files();
  if (files.empty()) GTEST_SKIP() << "SKIPPED: " << tree << " is not a checkout of git";
  for (const Annotation& annotation : annotations_of(content_of(tree / "REUSE.toml"))) {
    for (const std::string& pattern : annotation.paths) {
      EXPECT_TRUE(std::ranges::any_of(files, [&](const auto& file) {
        return matches_pattern(pattern, file);
      })) << pattern;
    }
  }
}

TEST(Licence, EachLicenceHasItsTextAndNoTextIsOfNone) {
  std::set<std::string> named;
  for (const Annotation& annotation : annotations_of(content_of(tree / "REUSE.toml")))
    named.insert(annotation.licence + ".txt");
  std::set<std::string> texts;
  for (const auto& entry : fs::directory_iterator(tree / "LICENSES")) {
    texts.insert(entry.path().filename().string());
    EXPECT_GT(content_of(entry.path()).size(), 500U) << entry.path();
  }
  EXPECT_EQ(named, texts);
  EXPECT_EQ(content_of(tree / "LICENSES/BSD-3-Clause.txt"), content_of(tree / "LICENSE"));
}

TEST(Licence, AFileWithoutAnnotationAnAssetAndAForeignNoticeAreFound) {
  const std::vector<Annotation> few = annotations_of(
      "[[annotations]]\npath = [\"core/*\", \"docs/**.svg\"]\nSPDX-FileCopyrightText = \"we\"\n"
      "SPDX-License-Identifier = \"MIT\"\n");
  EXPECT_EQ(licence_problem(few, "core/a.h", ""), "");
  EXPECT_EQ(licence_problem(few, "docs/results/a.svg", ""), "");
  EXPECT_EQ(licence_problem(few, "core/hough/a.h", ""),
            "core/hough/a.h: no annotation of REUSE.toml covers it");
  const std::vector<Annotation> all = annotations_of(
      "[[annotations]]\npath = \"**\"\nSPDX-FileCopyrightText = \"we\"\nSPDX-License-Identifier = \"MIT\"\n");
  EXPECT_EQ(licence_problem(all, "core/hough/a.h", "// text"), "");
  EXPECT_THAT(licence_problem(all, "web/jquery.js", ""), MatchesRegex("web/jquery.js: an asset .*"));
  EXPECT_THAT(licence_problem(all, "core/a.bin", std::string("\0", 1)),
              MatchesRegex("core/a.bin: an asset .*"));
  const std::string foreign = std::string("// Copyright") + " (c) 2020 Somebody\n";
  EXPECT_THAT(licence_problem(all, "core/a.h", foreign), MatchesRegex("core/a.h: Copyright .* Somebody, .*"));
}

/// The value of a key at the left margin of CITATION.cff.
std::string citation_value(const std::string& key) {
  std::istringstream lines(content_of(tree / "CITATION.cff"));
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with(key + ": ")) return line.substr(key.size() + 2);
  }
  return {};
}

TEST(Citation, HasWhatAnArchiveAsksForAndTheVersionOfTheProgram) {
  const std::string cmake = content_of(tree / "CMakeLists.txt");
  std::smatch version;
  ASSERT_TRUE(std::regex_search(cmake, version, std::regex(R"(project\(saccade VERSION ([0-9.]+))")));
  EXPECT_EQ(citation_value("version"), version[1]);
  EXPECT_EQ(citation_value("cff-version"), "1.2.0");
  EXPECT_EQ(citation_value("license"), "BSD-3-Clause");
  EXPECT_EQ(citation_value("type"), "software");
  EXPECT_TRUE(
      std::regex_match(citation_value("date-released"), std::regex("20[0-9]{2}-[01][0-9]-[0-3][0-9]")));
  const std::string text = content_of(tree / "CITATION.cff");
  for (const char* key : {"\ntitle: ", "\nabstract: ", "\nmessage: ", "\nauthors:\n  - ", "\nkeywords:\n  - ",
                          "\nreferences:\n  - ", "    doi: 10.1109/IROS.2016.7759345\n"})
    EXPECT_NE(text.find(key), std::string::npos) << key;
}

}  // namespace
}  // namespace saccade
