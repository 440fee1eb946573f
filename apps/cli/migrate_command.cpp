#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>

#include "apps/cli/commands.h"
#include "config/migrate.h"
#include "core/error.h"
#include "recording/output_file.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;

std::string text_of_file(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  if (!stream || fs::is_directory(path))
    throw InputError(path.string(), "no such file", "a readable YAML file");
  return {std::istreambuf_iterator<char>(stream), {}};
}

void write(const fs::path& path, const std::string& text) {
  OutputFile file(path);
  file.write(text);
  file.commit();
}

int migrate_file(const fs::path& named) {
  const std::string old_text = text_of_file(named);
  const Migration migration = migrate(old_text, named.string());
  if (migration.renames.empty()) {
    fmt::print("{}: nothing to do, it has the keys of today\n", named.string());
    return 0;
  }
  const fs::path path = fs::canonical(named);  // a link stays a link
  const fs::path backup = path.string() + ".bak";
  if (fs::exists(backup)) {
    throw InputError(backup.string(), "a file that exists",
                     "no such file: the old one is kept under this name");
  }
  const fs::perms permissions = fs::status(path).permissions();
  write(backup, old_text);
  write(path, migration.text);
  fs::permissions(path, permissions);
  fs::permissions(backup, permissions);
  for (const KeyRename& rename : migration.renames) {
    fmt::print("{}:{}: {} -> {}\n", named.string(), rename.line, rename.old_text, rename.new_text);
  }
  fmt::print("{}: {} rewritten; the old file is {}\n", named.string(),
             migration.renames.size() == 1 ? "1 key" : fmt::format("{} keys", migration.renames.size()),
             backup.string());
  return 0;
}

}  // namespace

void add_migrate_command(CommandLine& line) {
  auto file = std::make_shared<fs::path>();
  Command command = line.add_command("migrate", "Renames the keys of an old scenario, sweep or robot file");
  command.option("file", *file, "Scenario, sweep or robot file, rewritten in place").required();
  command.footer(
      "Comments, order and values stay as they are. The old file is kept as FILE.bak, which must not exist.");
  command.action([file] { return migrate_file(*file); });
}

}  // namespace saccade
