#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>
#include <vector>

#include "apps/cli/commands.h"
#include "apps/cli/man_page.h"
#include "apps/cli/shell_completion.h"
#include "core/error.h"
#include "recording/output_file.h"
#include "session/version.h"
#include "sim/data_directory.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;

/// Names of the scenarios that are shipped, sorted.
std::vector<std::string> shipped_scenario_names() {
  std::vector<std::string> names;
  for (const fs::directory_entry& entry : fs::directory_iterator(data_directory() / "scenarios")) {
    if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
  }
  std::ranges::sort(names);
  return names;
}

void write_page(const fs::path& path, const std::string& text) {
  std::error_code error;
  fs::create_directories(path.parent_path(), error);
  if (error) throw RunError(path.parent_path().string() + ": cannot be made: " + error.message());
  write_file(path, text);
}

void write_pages(const ProgramText& program, const fs::path& folder) {
  const std::vector<std::string> scenarios = shipped_scenario_names();
  for (const auto& [name, text] : man_pages(program, std::string(version()), std::string(release_date())))
    write_page(folder / "man/man1" / name, text);
  write_page(folder / "bash-completion/completions" / program.name, bash_completion(program, scenarios));
  write_page(folder / "zsh/vendor-completions" / ("_" + program.name), zsh_completion(program, scenarios));
}

}  // namespace

void add_command_pages_command(CommandLine& line) {
  auto folder = std::make_shared<fs::path>();
  Command command = line.add_command(
      "command-pages",
      "Writes the man pages and the completion for bash and zsh into a folder such as share/");
  command.hide();
  command.option("folder", *folder, "Folder to write below").required();
  command.action([folder, &line] {
    write_pages(line.text(), *folder);
    return 0;
  });
}

}  // namespace saccade
