// Holds the table of layers in docs/architecture.md: what each folder includes, links and reaches.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <ostream>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace saccade {
namespace {

namespace fs = std::filesystem;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

using Words = std::vector<std::string>;

struct Layer {
  Words may_include;
  Words may_link;
  Words must_not_reach;
};
using Table = std::map<std::string, Layer>;  // by folder, "core/"

std::string read_text(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

Words matches(const std::string& text, const char* pattern) {
  const std::regex regex(pattern);
  Words found;
  for (std::sregex_iterator it(text.begin(), text.end(), regex), end; it != end; ++it)
    found.push_back((*it)[1]);
  return found;
}

Words split(const std::string& line, char separator) {
  Words cells;
  std::istringstream stream(line);
  for (std::string cell; std::getline(stream, cell, separator);) cells.push_back(cell);
  return cells;
}

/// The rows `| `folder/` | what it is | may include | may link | must not reach |`, whose last cell may be "as `folder/`" of a row
/// above.
Table read_table(const std::string& markdown) {
  Table table;
  for (const std::string& line : split(markdown, '\n')) {
    if (!line.starts_with("| `")) continue;
    Words cells = split(line, '|');
    cells.resize(6);
    const auto words = [&](std::size_t i) { return matches(cells[i], "`([^`]+)`"); };
    const Words last = words(5);
    const bool as_above = cells[5].starts_with(" as `");
    table[words(1).at(0)] = {words(3), words(4), as_above ? table.at(last.at(0)).must_not_reach : last};
  }
  return table;
}

/// Whether one of the words names the header or a folder above it; "*" names all.
bool is_in(const Words& words, const std::string& name) {
  return std::any_of(words.begin(), words.end(), [&](const std::string& word) {
    return word == "*" || word == name || (word.ends_with('/') && name.starts_with(word));
  });
}

struct Source {
  std::string path;  // from the root, "core/event.h"
  std::string text;
};

/// Files of the tree that are C++ or CMake, without tests, builds and hidden folders.
std::vector<Source> read_sources(const fs::path& root) {
  const std::set<std::string> skipped = {"build", "runs", "tests", "cmake"};
  const std::set<std::string> kinds = {".h", ".hpp", ".inl", ".c", ".cc", ".cpp", ".cxx"};
  std::vector<Source> sources;
  for (auto it = fs::recursive_directory_iterator(root); it != fs::recursive_directory_iterator(); ++it) {
    const std::string name = it->path().filename().string();
    if (it->is_directory() && (name.starts_with('.') || (it.depth() == 0 && skipped.contains(name)))) {
      it.disable_recursion_pending();
    } else if (it->is_regular_file() && it.depth() > 0 &&
               (kinds.contains(it->path().extension().string()) || name == "CMakeLists.txt")) {
      sources.push_back({it->path().lexically_relative(root).string(), read_text(it->path())});
    }
  }
  return sources;
}

class Checker {
 public:
  explicit Checker(const fs::path& root)
      : table_(read_table(read_text(root / "docs/architecture.md"))), sources_(read_sources(root)) {
    for (const Source& source : sources_) {
      includes_[source.path] =
          matches(source.text, "(?:^|\\n)[ \\t]*#[ \\t]*include[ \\t]*[<\"]([^>\"\\n]*)[>\"]");
    }
    for (const Source& source : sources_) check(source);
  }

  [[nodiscard]] const Table& table() const { return table_; }
  [[nodiscard]] std::size_t file_count() const { return sources_.size(); }
  [[nodiscard]] const Words& violations() const { return violations_; }

 private:
  /// The row of the deepest folder that holds the file; the end of the table where there is none.
  [[nodiscard]] Table::const_iterator row_of(const std::string& path) const {
    auto row = table_.end();
    for (auto it = table_.begin(); it != table_.end(); ++it) {
      if (path.starts_with(it->first) && (row == table_.end() || it->first.size() > row->first.size()))
        row = it;
    }
    return row;
  }

  /// "*" grants all, "robot/ports.h" one header, "core/" that folder without the folders in it that have a row.
  [[nodiscard]] bool may_include(const Layer& layer, const std::string& header) const {
    const auto row = row_of(header);
    return std::any_of(layer.may_include.begin(), layer.may_include.end(), [&](const std::string& word) {
      return word == "*" || word == header ||
             (word.ends_with('/') && header.starts_with(word) &&
              (row == table_.end() || row->first.size() <= word.size()));
    });
  }

  void check(const Source& source) {
    const auto row = row_of(source.path);
    if (row == table_.end()) {
      violations_.push_back(source.path + ": in no folder of the table");
    } else if (source.path.ends_with("CMakeLists.txt")) {
      check_links(source, row->second);
    } else {
      check_includes(source, row->second);
    }
  }

  void check_includes(const Source& source, const Layer& layer) {
    for (const std::string& header : includes_.at(source.path)) {
      const bool standard = header.find_first_of("/.") == std::string::npos;
      if (!standard && !may_include(layer, header)) {
        violations_.push_back(source.path + ": may not include " + header);
      }
    }
    if (!matches(source.text, "(?:^|\\n)[ \\t]*#[ \\t]*include[ \\t]+([A-Za-z_])").empty()) {
      violations_.push_back(source.path + ": an include by macro, which nobody can check");
    }
    std::set<std::string> seen;
    check_reach(source.path, source.path, layer, seen);
  }

  void check_reach(const std::string& start, const std::string& path, const Layer& layer,
                   std::set<std::string>& seen) {
    if (!seen.insert(path).second) return;
    const auto includes = includes_.find(path);
    if (includes == includes_.end()) return;  // a header from elsewhere
    for (const std::string& header : includes->second) {
      if (is_in(layer.must_not_reach, header)) {
        violations_.push_back(start + ": must not reach " + header + " (by way of " + path + ")");
      }
      check_reach(start, header, layer, seen);
    }
  }

  void check_links(const Source& source, const Layer& layer) {
    const std::string text = std::regex_replace(source.text, std::regex("#[^\\n]*"), "");
    for (const std::string& call : matches(text, "saccade_layer\\s*\\(([^)]*)\\)")) {
      std::string keyword;
      for (const std::string& word : matches(call, "([^\\s\"]+)")) {
        const bool is_keyword =
            !matches(word, "^(SOURCES|LAYERS|LIBRARIES|PRIVATE_LIBRARIES|ALONE)$").empty();
        if (is_keyword) keyword = word;
        if (is_keyword || keyword.empty() || keyword == "SOURCES" || keyword == "ALONE") continue;
        check_link(source, layer, keyword == "LAYERS" ? "saccade_" + word : word);
      }
    }
    for (const std::string& call : matches(text, "link_libraries\\s*\\(([^)]*)\\)")) {
      Words words = matches(call, "([^\\s\"]+)");
      if (!words.empty()) words.erase(words.begin());  // the target
      for (const std::string& word : words) {
        if (word != "PUBLIC" && word != "PRIVATE" && word != "INTERFACE") check_link(source, layer, word);
      }
    }
  }

  void check_link(const Source& source, const Layer& layer, const std::string& library) {
    if (!is_in(layer.may_link, library)) violations_.push_back(source.path + ": may not link " + library);
  }

  Table table_;
  std::vector<Source> sources_;
  std::map<std::string, Words> includes_;
  Words violations_;
};

TEST(Architecture, EveryIncludeAndLinkKeepsToTheTableOfLayers) {
  const Checker checker(SACCADE_SOURCE_DIR);
  EXPECT_THAT(checker.violations(), IsEmpty());
  EXPECT_GT(checker.file_count(), 20u);  // it did look at something
}

TEST(Architecture, TheTableHasARowForEveryLayer) {
  const Checker checker(SACCADE_SOURCE_DIR);
  for (const char* layer :
       {"core/", "control/", "emulator/", "recording/", "robot/", "loop/", "sim/", "evaluation/scoring/",
        "config/", "session/", "worlds/", "core/tracker/", "apps/"}) {
    EXPECT_TRUE(checker.table().contains(layer)) << layer;
  }
}

TEST(Architecture, OnlyTheCompositionRootMayIncludeAndLinkEverything) {
  const Checker checker(SACCADE_SOURCE_DIR);
  for (const auto& [folder, layer] : checker.table()) {
    const bool everything =
        is_in(layer.may_include, "a/header/of/no/layer.h") || is_in(layer.may_link, "a_library_of_no_layer");
    EXPECT_EQ(everything, folder == "apps/") << folder;
  }
}

TEST(Architecture, NoSourceOfALayerIsLongerThan500Lines) {
  std::size_t files = 0;
  for (const Source& source : read_sources(SACCADE_SOURCE_DIR)) {
    EXPECT_LE(std::count(source.text.begin(), source.text.end(), '\n'), 500) << source.path;
    ++files;
  }
  EXPECT_GT(files, 300U);
}

/// A tree with the project's own table and a few innocent files, on disk as long as it lives.
class SmallTree {
 public:
  SmallTree() : root_(fs::temp_directory_path() / ("saccade_architecture_" + std::to_string(::getpid()))) {
    fs::remove_all(root_);
    write("docs/architecture.md", read_text(fs::path(SACCADE_SOURCE_DIR) / "docs/architecture.md"));
    write("core/event.h", "#include <cstdint>\n");
    write("core/detector.h", "#include \"core/event.h\"\n");
    write("robot/ports.h", "#include <Eigen/Core>\n#include \"core/event.h\"\n");
    write("robot/fake/fake.h", "#include \"robot/ports.h\"\n");
    write("sim/world.cpp", "#include <mujoco/mujoco.h>\n#include \"robot/ports.h\"\n");
    write("core/CMakeLists.txt",
          "saccade_layer(core\n  SOURCES a.cpp # not LIBRARIES mujoco\n  LIBRARIES Eigen3::Eigen)\n");
  }
  SmallTree(const SmallTree&) = delete;
  SmallTree& operator=(const SmallTree&) = delete;
  ~SmallTree() { fs::remove_all(root_); }

  void write(const fs::path& path, const std::string& text) const {
    fs::create_directories((root_ / path).parent_path());
    std::ofstream(root_ / path) << text;
  }
  [[nodiscard]] Words violations() const { return Checker(root_).violations(); }

 private:
  fs::path root_;
};

TEST(Architecture, FindsNothingWrongWithAnInnocentTree) { EXPECT_THAT(SmallTree().violations(), IsEmpty()); }

struct Plant {
  const char* name;
  const char* path;
  const char* text;
  const char* violation;
};

std::ostream& operator<<(std::ostream& out, const Plant& plant) { return out << plant.name; }

class PlantedViolation : public testing::TestWithParam<Plant> {};

TEST_P(PlantedViolation, IsFound) {
  const SmallTree tree;
  tree.write(GetParam().path, GetParam().text);
  EXPECT_THAT(tree.violations(), Contains(HasSubstr(GetParam().violation)));
}

INSTANTIATE_TEST_SUITE_P(
    Architecture, PlantedViolation,
    testing::Values(
        Plant{"mujocoInCore", "core/a.cpp", "#include <mujoco/mujoco.h>\n",
              "core/a.cpp: may not include mujoco/mujoco.h"},
        Plant{"spacesInTheInclude", "core/a.h", "int a;\n  #  include<opencv2/core.hpp>",
              "core/a.h: may not include opencv2/core.hpp"},
        Plant{"clockInCore", "core/a.cpp", "#include <chrono>\n", "core/a.cpp: must not reach chrono"},
        Plant{"fileInControl", "control/a.cpp", "#include <fstream>\n",
              "control/a.cpp: must not reach fstream"},
        Plant{"layerInAngles", "core/a.cpp", "#include <control/target.h>\n",
              "core/a.cpp: may not include control/target.h"},
        Plant{"pathUpwards", "emulator/a.cpp", "#include \"../sim/world.h\"\n",
              "emulator/a.cpp: may not include ../sim/world.h"},
        Plant{"macro", "core/a.cpp", "#include HEADER\n", "core/a.cpp: an include by macro"},
        Plant{"simulatorInRobot", "robot/a.cpp", "#include \"sim/world.h\"\n",
              "robot/a.cpp: may not include sim/world.h"},
        Plant{"backendInSim", "sim/a.cpp", "#include \"robot/fake/fake.h\"\n",
              "sim/a.cpp: may not include robot/fake/fake.h"},
        Plant{"detectorInSim", "sim/a.cpp", "#include \"core/detector.h\"\n",
              "sim/a.cpp: must not reach core/detector.h"},
        Plant{"detectorInEmulatorByWayOfAnother", "core/event.h", "#include \"core/detector.h\"\n",
              "sim/world.cpp: must not reach core/detector.h (by way of core/event.h)"},
        Plant{"trackerInTheVocabulary", "core/a.h", "#include \"core/tracker/a.h\"\n",
              "core/a.h: may not include core/tracker/a.h"},
        Plant{"trackerInTheSimulator", "sim/a.cpp", "#include \"core/tracker/a.h\"\n",
              "sim/a.cpp: may not include core/tracker/a.h"},
        Plant{"programInALibrary", "session/CMakeLists.txt",
              "saccade_layer(session SOURCES a.cpp LAYERS sweep)",
              "session/CMakeLists.txt: may not link saccade_sweep"},
        Plant{"mujocoInScoring", "evaluation/scoring/a.cpp", "#include <mujoco/mujoco.h>\n",
              "evaluation/scoring/a.cpp: may not include mujoco/mujoco.h"},
        Plant{"yamlInACommand", "apps/run.cpp", "#include <yaml-cpp/yaml.h>\n",
              "apps/run.cpp: must not reach yaml-cpp/yaml.h"},
        Plant{"folderWithoutARow", "tools/a.cpp", "int a;\n", "tools/a.cpp: in no folder of the table"},
        Plant{"layerLinked", "core/CMakeLists.txt", "saccade_layer(core SOURCES a.cpp LAYERS control)",
              "core/CMakeLists.txt: may not link saccade_control"},
        Plant{"libraryLinked", "control/CMakeLists.txt",
              "saccade_layer(control SOURCES a.cpp\n LAYERS core\n PRIVATE_LIBRARIES mujoco::mujoco)",
              "control/CMakeLists.txt: may not link mujoco::mujoco"},
        Plant{"linkedByTheSide", "robot/CMakeLists.txt",
              "target_link_libraries(saccade_robot PRIVATE saccade_sim)",
              "robot/CMakeLists.txt: may not link saccade_sim"}));

}  // namespace
}  // namespace saccade
