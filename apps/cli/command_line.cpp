#include "apps/cli/command_line.h"

#include <fcntl.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <limits>
#include <optional>
#include <system_error>

#include "core/config.h"
#include "core/error.h"
#include "core/nearest_name.h"
#include "recording/number_text.h"

namespace saccade::inline v0_1 {
namespace {

CLI::Option& parser(ParserOption* option) { return *reinterpret_cast<CLI::Option*>(option); }
CLI::App& parser(ParserCommand* command) { return *reinterpret_cast<CLI::App*>(command); }
Option option_of(CLI::Option* option) { return Option(reinterpret_cast<ParserOption*>(option)); }

/// A check of an option's number. `fits`: whether it takes the number; `words`: which it takes, for help and messages.
CLI::Validator number_check(std::function<bool(double)> fits, const std::string& words) {
  const auto check = [fits = std::move(fits), words](const std::string& text) {
    double value = std::numeric_limits<double>::quiet_NaN();
    const bool is_number = parse_number(std::string_view(text).substr(text.starts_with('+') ? 1 : 0), value);
    return is_number && fits(value) ? std::string() : "found " + text + ", expected a number " + words;
  };
  return {check, words};
}

/// The arguments with hyphens in the names of options: --no_joints is --no-joints.
std::vector<std::string> hyphenated(int argc, const char* const* argv) {
  std::vector<std::string> words(argv, argv + argc);
  for (std::string& word : words) {
    if (word == "--") break;
    const auto end = word.starts_with("--") ? std::ranges::find(word, '=') : word.begin();
    std::replace(word.begin(), end, '_', '-');
  }
  return words;
}

/// A word that starts with `-` and is neither an option of the command nor a number.
std::string unknown_option(const CLI::App& command) {
  for (const std::string& word : command.remaining()) {
    if (word.size() > 1 && word.front() == '-' && word != "--") return word.substr(0, word.find('='));
  }
  return {};
}

/// Prints to standard error what stands instead of a known word.
int print_unknown(const std::string& place, const std::string& kind, const std::vector<std::string>& known) {
  const std::string word = place.substr(place.rfind(' ') + 1);
  const std::string close = nearest_name(word, known);
  const std::string expectation =
      close.empty() ? expectation_of(known) : "a known " + kind + "; did you mean " + close + "?";
  std::fprintf(stderr, "%s: found an unknown %s, expected %s\nRun with --help for more information.\n",
               place.c_str(), kind.c_str(), expectation.c_str());
  return 2;
}

/// Files of the program take the numbers of standard files that are closed, and would get what is printed.
void open_standard_files() {
  for (const int file : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (::fcntl(file, F_GETFD) >= 0) continue;
    // Standard output cannot be written then, and finish_output() reports it.
    const int opened = ::open("/dev/null", file == STDERR_FILENO ? O_WRONLY : O_RDONLY);
    if (opened >= 0 && opened != file) ::close(opened);
  }
}

/// Writes what was printed. Returns the exit status: 1 where the action's is 0 and something could not be written.
int finish_output(int status) {
  errno = 0;
  std::cout.flush();
  const bool flushed = std::fflush(stdout) == 0;
  if (flushed && std::ferror(stdout) == 0 && std::cout) return status;
  const std::string cause = errno != 0 ? ": " + std::generic_category().message(errno) : std::string();
  std::fprintf(stderr, "saccade: standard output: cannot be written%s\n", cause.c_str());
  return status == 0 ? 1 : status;
}

}  // namespace

Option& Option::required() {
  parser(option_).required();
  return *this;
}

Option& Option::show_default() {
  parser(option_).capture_default_str();
  return *this;
}

Option& Option::in_range(double min, double max) {
  parser(option_).check(number_check([=](double value) { return value >= min && value <= max; },
                                     expectation_of(Range{min, max}, "").substr(1)));
  return *this;
}

Option& Option::positive() {
  parser(option_).check(
      number_check([](double value) { return value > 0.0 && std::isfinite(value); }, "above 0"));
  return *this;
}

Option& Option::one_of(std::vector<std::string> words) {
  parser(option_).check(CLI::IsMember(std::move(words)));
  return *this;
}

Option& Option::one_value_each() {
  parser(option_).allow_extra_args(false);
  return *this;
}

Option& Option::excludes(const Option& other) {
  parser(option_).excludes(&parser(other.option_));
  return *this;
}

template <class T>
Option Command::option(const std::string& name, T& value, const std::string& help) {
  return option_of(parser(command_).add_option(name, value, help));
}
template Option Command::option(const std::string&, std::string&, const std::string&);
template Option Command::option(const std::string&, std::filesystem::path&, const std::string&);
template Option Command::option(const std::string&, std::vector<std::string>&, const std::string&);
template Option Command::option(const std::string&, std::vector<std::filesystem::path>&, const std::string&);
template Option Command::option(const std::string&, double&, const std::string&);
template Option Command::option(const std::string&, int&, const std::string&);
template Option Command::option(const std::string&, std::int64_t&, const std::string&);
template Option Command::option(const std::string&, std::size_t&, const std::string&);
template Option Command::option(const std::string&, std::optional<double>&, const std::string&);
template Option Command::option(const std::string&, std::optional<std::int64_t>&, const std::string&);

Option Command::option(const std::string& name, std::function<void(const std::string&)> read,
                       const std::string& help) {
  return option_of(parser(command_).add_option_function<std::string>(name, std::move(read), help));
}

Option Command::flag(const std::string& name, bool& value, const std::string& help) {
  return option_of(parser(command_).add_flag(name, value, help));
}

void Command::footer(const std::string& text) { parser(command_).footer(text); }

void Command::hide() { parser(command_).group(""); }

void Command::action(std::function<int()> action) {
  parser(command_).callback([chosen = chosen_, action = std::move(action)] { *chosen = action; });
}

struct CommandLine::Parser {
  CLI::App app;
  std::function<int()> chosen;
  std::function<std::string()> version;

  /// Returns the exit status.
  int parse_and_act(int argc, const char* const* argv);
};

CommandLine::CommandLine(const std::string& name, const std::string& description, const std::string& footer)
    : parser_(std::make_unique<Parser>()) {
  parser_->app.name(name);
  parser_->app.description(description);
  parser_->app.footer(footer);
  parser_->app.require_subcommand(1);
}

CommandLine::~CommandLine() = default;

Command CommandLine::add_command(const std::string& name, const std::string& help) {
  CLI::App* const command = parser_->app.add_subcommand(name, help);
  return Command(reinterpret_cast<ParserCommand*>(command), &parser_->chosen);
}

void CommandLine::add_version(std::function<std::string()> text) {
  const auto ask = [this, text = std::move(text)] {
    parser_->version = text;
    throw CLI::Success();
  };
  parser_->app.add_flag_callback("--version", ask, "Print version, commit, MuJoCo and OpenGL");
}

int CommandLine::Parser::parse_and_act(int argc, const char* const* argv) {
  std::vector<std::string> words = hyphenated(argc, argv);
  std::vector<std::string> names;
  bool is_known = words.size() < 2 || words[1].starts_with('-');
  for (const CLI::App* const command : app.get_subcommands([](const CLI::App*) { return true; })) {
    is_known = is_known || command->get_name() == words[1];
    if (!command->get_group().empty()) names.push_back(command->get_name());
  }
  if (!is_known) return print_unknown("saccade: " + words[1], "command", names);
  std::vector<std::string> reversed(words.rbegin(), words.rend() - 1);
  try {
    app.parse(reversed);
  } catch (const CLI::ExtrasError& error) {
    const std::vector<CLI::App*> parsed = app.get_subcommands();
    const CLI::App& command = parsed.empty() ? app : *parsed.front();
    const std::string option = unknown_option(command);
    if (option.empty()) return app.exit(error) == 0 ? 0 : 2;
    names.clear();
    for (const CLI::Option* const known : command.get_options()) {
      if (!known->get_positional()) names.push_back(known->get_name());
    }
    return print_unknown("saccade " + command.get_name() + ": " + option, "option", names);
  } catch (const CLI::ParseError& error) {
    if (!version) return app.exit(error) == 0 ? 0 : 2;
    std::puts(version().c_str());
    return 0;
  }
  return chosen();
}

int CommandLine::run(int argc, const char* const* argv) {
  // A file beyond the limit of `ulimit -f` is an error of its write, with a message, instead of the end of the program.
  std::signal(SIGXFSZ, SIG_IGN);
  open_standard_files();
  try {
    return finish_output(parser_->parse_and_act(argc, argv));
  } catch (const std::system_error& error) {
    if (std::ferror(stdout) == 0) {
      std::fprintf(stderr, "saccade: %s\n", error.what());
    } else {
      std::fprintf(stderr, "saccade: standard output: cannot be written: %s\n",
                   error.code().message().c_str());
    }
    return 1;
  } catch (const InputError& error) {
    std::fprintf(stderr, "saccade: %s\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "saccade: %s\n", error.what());
    return 1;
  }
}

}  // namespace saccade::inline v0_1
