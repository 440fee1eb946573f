#include "apps/external/external_config.h"

#include <filesystem>
#include <sstream>

#include "recording/helper_reader.h"

namespace saccade::inline v0_1 {
namespace {

constexpr std::string_view worker_program = "saccade-worker";

void describe_limits(FieldVisitor& v, AnswerLimits& limits) {
  v.real("start_limit_s", limits.start_limit_s, {0.1, 600.0},
         "wall-clock time from the start of the program, or of the connection, to its line `ready`");
  v.real("answer_limit_s", limits.answer_limit_s, {0.01, 600.0},
         "wall-clock time for the answer to a tick; a later answer ends the program");
}

void add_arguments(const std::string& arguments, std::vector<std::string>& words) {
  std::istringstream text(arguments);
  for (std::string word; text >> word;) words.push_back(word);
}

void require_file(const std::string& key, const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) throw InputError(key, path, "a file that exists");
}

}  // namespace

void describe(FieldVisitor& v, PythonConfig& config) {
  v.path("python", config.python, "FILE.py:CLASS; relative to the file that names it");
  const std::size_t colon = config.python.rfind(':');
  const bool is_class = colon != std::string::npos && colon > 0 && colon + 1 < config.python.size();
  v.require(is_class, "python", config.python.empty() ? "nothing" : config.python, "FILE.py:CLASS");
  v.text("interpreter", config.interpreter, "Python 3 with NumPy, a path or a name in PATH");
  v.text("arguments", config.arguments, "keyword arguments of the class, such as `decay_ms=20 votes=True`");
  describe_limits(v, config.limits);
}

void describe(FieldVisitor& v, CommandConfig& config) {
  v.path("command", config.command, "the program; relative to the file that names it");
  v.require(!config.command.empty(), "command", "nothing", "the path of a program");
  v.text("arguments", config.arguments, "arguments of the program, separated by spaces");
  describe_limits(v, config.limits);
}

void describe(FieldVisitor& v, SocketConfig& config) {
  v.text("socket", config.socket,
         "where the program listens: HOST:PORT, or the path of a Unix socket, with a /");
  v.require(parse_socket_address(config.socket).has_value(), "socket",
            config.socket.empty() ? "nothing" : config.socket, "HOST:PORT or a path with a /");
  describe_limits(v, config.limits);
}

std::vector<std::string> command_line_of(const PythonConfig& config, const std::string& section) {
  check_config("python", config);
  require_file(section + "python", config.python.substr(0, config.python.rfind(':')));
  std::vector<std::string> words = {config.interpreter, find_helper(worker_program).string(), config.python};
  add_arguments(config.arguments, words);
  return words;
}

std::vector<std::string> command_line_of(const CommandConfig& config, const std::string& section) {
  check_config("command", config);
  require_file(section + "command", config.command);
  std::vector<std::string> words = {config.command};
  add_arguments(config.arguments, words);
  return words;
}

SocketAddress address_of(const SocketConfig& config) {
  check_config("socket", config);
  return parse_socket_address(config.socket).value();
}

}  // namespace saccade::inline v0_1
