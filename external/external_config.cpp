#include "external/external_config.h"

#include <cstdlib>
#include <filesystem>
#include <sstream>

#include "recording/helper_reader.h"

namespace saccade {
namespace {

constexpr std::string_view worker_program = "saccade-worker";

void describe_limits(FieldVisitor& v, AnswerLimits& limits) {
  v.real("start_limit_s", limits.start_limit_s, {0.1, 600.0},
         "wall-clock time from the start of the program, or of the connection, to its line `ready`");
  v.real("answer_limit_s", limits.answer_limit_s, {0.01, 600.0},
         "wall-clock time for the answer to a tick; a later answer ends the program");
}

namespace fs = std::filesystem;

std::vector<std::string> words_of(const std::string& arguments) {
  std::vector<std::string> words;
  std::istringstream text(arguments);
  for (std::string word; text >> word;) words.push_back(word);
  return words;
}

bool is_file(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

void require_file(const std::string& key, const std::string& path) {
  if (!is_file(path)) throw InputError(key, path, "a file that exists");
}

void require_folder(const std::string& key, const std::string& path) {
  std::error_code ignored;
  if (!path.empty() && !fs::is_directory(path, ignored)) throw InputError(key, path, "a folder that exists");
}

/// The file of a program; a name without a slash is sought in PATH. Empty where there is none.
std::string file_of(const std::string& program) {
  if (program.find('/') != std::string::npos) return is_file(program) ? program : std::string();
  const char* const path = std::getenv("PATH");
  std::istringstream folders(path != nullptr ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');) {
    if (!folder.empty() && is_file(fs::path(folder) / program)) return fs::path(folder) / program;
  }
  return {};
}

std::string file_of_class(const std::string& python) { return python.substr(0, python.rfind(':')); }

/// The files that arguments name: a word, or what follows its `=`.
std::vector<std::string> files_in(const std::string& arguments, const std::string& folder) {
  std::vector<std::string> files;
  for (const std::string& word : words_of(arguments)) {
    for (const std::string& name : {word, word.substr(word.find('=') + 1)}) {
      if (!name.empty() && is_file(fs::path(folder) / name)) files.push_back(fs::path(folder) / name);
    }
  }
  return files;
}

/// By default the folder of the file that names the program.
void describe_folder(FieldVisitor& v, std::string_view program_key, std::string& folder) {
  if (const auto named_in = v.folder_of(program_key)) folder = *named_in;
  v.path(
      "folder", folder,
      "working directory of the program, which its arguments are relative to; by default the folder of the "
      "file that names the program");
}

}  // namespace

void describe(FieldVisitor& v, PythonConfig& config) {
  v.path("python", config.python, "FILE.py:CLASS; relative to the file that names it");
  const std::size_t colon = config.python.rfind(':');
  const bool is_class = colon != std::string::npos && colon > 0 && colon + 1 < config.python.size();
  v.require(is_class, "python", config.python.empty() ? "nothing" : config.python, "FILE.py:CLASS");
  v.program("interpreter", config.interpreter,
            "Python 3 with NumPy: a path, relative to the file that names it, or a name in PATH");
  v.text("arguments", config.arguments, "keyword arguments of the class, such as `decay_ms=20 votes=True`");
  describe_folder(v, "python", config.folder);
  v.reads("python", config.folder, [&config] {
    std::vector<std::string> files = files_in(config.arguments, config.folder);
    files.insert(files.begin(), file_of_class(config.python));
    return files;
  });
  describe_limits(v, config.limits);
}

void describe(FieldVisitor& v, CommandConfig& config) {
  v.program("command", config.command,
            "the program: a path, relative to the file that names it, or a name in PATH");
  v.require(!config.command.empty(), "command", "nothing", "the path of a program");
  v.text("arguments", config.arguments, "arguments of the program, separated by spaces");
  describe_folder(v, "command", config.folder);
  v.reads("command", config.folder, [&config] {
    std::vector<std::string> files = files_in(config.arguments, config.folder);
    files.insert(files.begin(), file_of(config.command));
    return files;
  });
  describe_limits(v, config.limits);
}

void describe(FieldVisitor& v, SocketConfig& config) {
  v.text("socket", config.socket,
         "where the program listens: HOST:PORT, or the path of a Unix socket, with a /");
  v.require(parse_socket_address(config.socket).has_value(), "socket",
            config.socket.empty() ? "nothing" : config.socket, "HOST:PORT or a path with a /");
  describe_limits(v, config.limits);
}

ProgramCall program_call(const PythonConfig& config, const std::string& section) {
  check_config("python", config);
  require_file(section + "python", file_of_class(config.python));
  require_folder(section + "folder", config.folder);
  const std::string python =
      fs::absolute(config.python).string();  // whatever the program's working directory is
  ProgramCall call{{config.interpreter, find_helper(worker_program).string(), python}, config.folder};
  for (std::string& word : words_of(config.arguments)) call.words.push_back(std::move(word));
  return call;
}

ProgramCall program_call(const CommandConfig& config, const std::string& section) {
  check_config("command", config);
  const std::string file = file_of(config.command);
  if (file.empty())
    throw InputError(section + "command", config.command,
                     config.command.find('/') != std::string::npos
                         ? "a file that exists"
                         : "a file beside the one that names it, or a program in PATH");
  require_folder(section + "folder", config.folder);
  ProgramCall call{{fs::absolute(file).string()}, config.folder};
  for (std::string& word : words_of(config.arguments)) call.words.push_back(std::move(word));
  return call;
}

SocketAddress address_of(const SocketConfig& config) {
  check_config("socket", config);
  return parse_socket_address(config.socket).value();
}

}  // namespace saccade
