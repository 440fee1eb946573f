#include "config/mentioned_files.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <iterator>
#include <set>
#include <sstream>
#include <string_view>

namespace saccade {
namespace {

namespace fs = std::filesystem;
using Names = std::set<std::string, std::less<>>;

constexpr std::uintmax_t longest_text = std::uintmax_t{1} << 20;
constexpr std::size_t longest_name = 255;

bool is_regular(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

bool is_folder(const fs::path& path) {
  std::error_code ignored;
  return fs::is_directory(path, ignored);
}

bool is_of_the_system(const fs::path& path) {
  constexpr std::array<std::string_view, 9> places = {"/usr/", "/bin/",  "/sbin/", "/lib/", "/lib64/",
                                                      "/etc/", "/proc/", "/sys/",  "/dev/"};
  const std::string text = path.string();
  return std::ranges::any_of(places, [&](std::string_view place) { return text.starts_with(place); });
}

/// Empty for a binary or long file.
std::string text_to_search(const fs::path& path) {
  std::error_code error;
  const std::uintmax_t size = fs::file_size(path, error);
  if (error || size > longest_text) return {};
  std::ifstream file(path, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(file), {}};
  return text.find('\0') == std::string::npos ? text : std::string();
}

/// What stands between two equal quotes on one line. Each quote may be the first of a pair, since a text may hold others.
Names quoted_in(std::string_view text) {
  Names names;
  for (std::size_t begin = text.find_first_of("\"'"); begin != std::string_view::npos;
       begin = text.find_first_of("\"'", begin + 1)) {
    const std::size_t end = text.find_first_of(std::string("\n") + text[begin], begin + 1);
    if (end == std::string_view::npos || text[end] == '\n') continue;
    const std::string_view name = text.substr(begin + 1, end - begin - 1);
    if (!name.empty() && name.size() <= longest_name) names.emplace(name);
  }
  return names;
}

/// Words with a dot or a slash that are no numbers, and what follows each of their slashes: of `$HERE/a.txt` a.txt.
Names paths_in(std::string_view text) {
  constexpr std::string_view separators = " \t\r\n\"'`()[]{}<>|&;,=:*?!#$%@^\\";
  Names names;
  for (std::size_t begin = text.find_first_not_of(separators); begin < text.size();) {
    const std::size_t end = std::min(text.find_first_of(separators, begin), text.size());
    const std::string_view word = text.substr(begin, end - begin);
    begin = text.find_first_not_of(separators, end);
    if (word.size() > longest_name || word.find_first_of("./") == std::string_view::npos ||
        word.find_first_not_of("0123456789.eE+-") == std::string_view::npos)
      continue;
    names.emplace(word);
    for (std::size_t slash = word.find('/'); slash != std::string_view::npos;
         slash = word.find('/', slash + 1)) {
      if (slash + 1 < word.size()) names.emplace(word.substr(slash + 1));
    }
  }
  return names;
}

Names identifiers_in(std::string_view text) {
  constexpr std::string_view letters = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_0123456789";
  Names names;
  for (std::size_t begin = text.find_first_of(letters); begin < text.size();) {
    const std::size_t end = std::min(text.find_first_not_of(letters, begin), text.size());
    names.emplace(text.substr(begin, std::min(end - begin, longest_name)));
    begin = text.find_first_of(letters, end);
  }
  return names;
}

/// The identifiers of the lines that import something.
Names imported_in(const std::string& text) {
  Names names;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.find("import") != std::string::npos) names.merge(identifiers_in(line));
  }
  return names;
}

/// All Python files of a package, sorted.
std::vector<fs::path> package_files(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  for (auto at = fs::recursive_directory_iterator(folder, error); !error && at != end(at);
       at.increment(error)) {
    if (at->path().extension() == ".py" && is_regular(at->path())) files.push_back(at->path());
  }
  std::ranges::sort(files);
  return files;
}

class Search {
 public:
  void search(const fs::path& file, std::vector<fs::path> folders) {
    const std::string text = text_to_search(file);
    if (text.empty()) return;
    folders.insert(folders.begin(), file.parent_path());
    const Names quoted = quoted_in(text);
    const std::vector<fs::path> outer = folders;
    for (const std::string& name : quoted) {
      if (name.find_first_not_of("./") == std::string::npos) continue;
      for (const fs::path& folder : outer) {
        if (is_folder(folder / name)) folders.push_back(folder / name);
      }
    }
    for (const std::string& name : quoted) add_named(name, folders);
    for (const std::string& name : paths_in(text)) add_named(name, folders);
    if (file.extension() != ".py") return;
    for (const std::string& name : identifiers_in(text)) add_named(name + ".py", folders);
    for (const std::string& name : imported_in(text)) {
      for (const fs::path& folder : outer) {
        for (const fs::path& module : package_files(folder / name)) add(module, folders);
      }
    }
  }

  /// `file` itself is not listed.
  void leave_out(const fs::path& file) { seen_.insert(normal(file)); }
  [[nodiscard]] std::vector<std::string> take() && { return std::move(found_); }

 private:
  static std::string normal(const fs::path& path) {
    return (fs::current_path() / path).lexically_normal().string();
  }
  void add_named(const std::string& name, const std::vector<fs::path>& folders) {
    for (const fs::path& folder : folders) {
      if (is_regular(folder / name)) add(folder / name, folders);
    }
  }
  void add(const fs::path& file, const std::vector<fs::path>& folders) {
    const std::string path = normal(file);
    if (is_of_the_system(path) || !seen_.insert(path).second) return;
    found_.push_back(path);
    search(path, folders);
  }

  std::set<std::string> seen_;
  std::vector<std::string> found_;
};

}  // namespace

std::vector<std::string> mentioned_files(const fs::path& file, const fs::path& folder) {
  Search search;
  search.leave_out(file);
  search.search(file, {folder.empty() ? fs::current_path() : folder});
  return std::move(search).take();
}

}  // namespace saccade
