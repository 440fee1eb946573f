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
#include <deque>
#include <filesystem>
#include <iostream>
#include <limits>
#include <optional>
#include <system_error>
#include <type_traits>

#include "core/config.h"
#include "core/error.h"
#include "core/nearest_name.h"
#include "recording/number_text.h"

namespace saccade {

/// An option, and what CLI11 does not tell of it.
struct ParserOption {
  CLI::Option* option = nullptr;
  Offer offer = Offer::nothing;
  std::string range = {};
  std::function<std::vector<std::string>()> words = {};
  bool only_words = false;
};

struct ParserCommand {
  CLI::App* app = nullptr;
  std::function<int()>* chosen = nullptr;
  std::deque<ParserOption> options = {};  // their places in memory stay
  std::string footer = {};

  Option add(CLI::Option* option, Offer offer = Offer::nothing) {
    options.push_back({option, offer});
    return Option(&options.back());
  }
};

namespace {

/// A check of an option's number. `fits`: whether it takes the number; `words`: which it takes, for help and messages.
CLI::Validator number_check(std::function<bool(double)> fits, const std::string& words) {
  const auto check = [fits = std::move(fits), words](const std::string& text) {
    double value = std::numeric_limits<double>::quiet_NaN();
    const bool is_number = parse_number(std::string_view(text).substr(text.starts_with('+') ? 1 : 0), value);
    return is_number && fits(value) ? std::string() : "found " + text + ", expected a number " + words;
  };
  return {check, words};
}

OptionText text_of(const ParserOption& known) {
  const CLI::Option& option = *known.option;
  OptionText text;
  text.help = option.get_description();
  if (option.get_positional()) {
    text.names = {option.get_name(true)};
  } else {
    for (const std::string& name : option.get_snames()) text.names.push_back("-" + name);
    for (const std::string& name : option.get_lnames()) text.names.push_back("--" + name);
  }
  if (option.get_items_expected_max() > 0) {
    const std::string type = option.get_type_name();
    text.type = type.substr(0, type.find(':'));  // checks follow
    text.default_value = option.get_default_str();
  }
  text.range = known.range;
  if (known.words) text.words = known.words();
  text.only_words = known.only_words;
  text.offer = known.offer;
  text.required = option.get_required();
  text.repeats = option.get_expected_max() == CLI::detail::expected_max_vector_size;
  for (const CLI::Option* const other : option.get_excludes()) text.excludes.push_back(other->get_name());
  std::ranges::sort(text.excludes);  // they are kept by their addresses
  return text;
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
  option_->option->required();
  return *this;
}

Option& Option::show_default() {
  option_->option->capture_default_str();
  return *this;
}

Option& Option::in_range(double min, double max) {
  option_->range = expectation_of(Range{min, max}, "").substr(1);
  option_->option->check(
      number_check([=](double value) { return value >= min && value <= max; }, option_->range));
  return *this;
}

Option& Option::positive() {
  option_->range = "above 0";
  option_->option->check(
      number_check([](double value) { return value > 0.0 && std::isfinite(value); }, option_->range));
  return *this;
}

Option& Option::one_of(std::vector<std::string> words) {
  option_->words = [words] { return words; };
  option_->only_words = true;
  option_->option->check(CLI::IsMember(std::move(words)));
  return *this;
}

Option& Option::offers(std::function<std::vector<std::string>()> words) {
  option_->words = std::move(words);
  return *this;
}

Option& Option::offers_scenarios() {
  option_->offer = Offer::files_and_scenarios;
  return *this;
}

Option& Option::one_value_each() {
  CLI::Option& option = *option_->option;
  option.allow_extra_args(false)->option_text(option.get_type_name());
  option.description(option.get_description() + " (repeatable)");
  return *this;
}

Option& Option::value_optional() {
  option_->option->expected(0, 1)->default_str("");
  return *this;
}

Option& Option::excludes(const Option& other) {
  option_->option->excludes(other.option_->option);
  return *this;
}

template <class T>
Option Command::option(const std::string& name, T& value, const std::string& help) {
  using Path = std::filesystem::path;
  constexpr bool is_path = std::is_same_v<T, Path> || std::is_same_v<T, std::vector<Path>>;
  CLI::Option* const option = command_->app->add_option(name, value, help);
  if (is_path) option->type_name("PATH");
  return command_->add(option, is_path ? Offer::files : Offer::nothing);
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

Option Command::option(const std::string& name, const std::function<void(const std::string&)>& read,
                       const std::string& help) {
  return command_->add(command_->app->add_option_function<std::string>(name, read, help));
}

Option Command::flag(const std::string& name, bool& value, const std::string& help) {
  return command_->add(command_->app->add_flag(name, value, help));
}

void Command::footer(const std::string& text) {
  command_->footer = text;
  command_->app->footer(text);
}

void Command::hide() { command_->app->group(""); }

void Command::action(std::function<int()> action) {
  command_->app->callback([chosen = command_->chosen, action = std::move(action)] { *chosen = action; });
}

struct CommandLine::Parser {
  CLI::App app;
  std::function<int()> chosen;
  std::function<std::string()> version;
  std::deque<ParserCommand> commands;  // their places in memory stay
  std::vector<ExitStatus> statuses;
  std::vector<EnvironmentVariable> environment;

  /// Returns the exit status.
  int parse_and_act(int argc, const char* const* argv);
};

CommandLine::CommandLine(const std::string& name, const std::string& description,
                         std::vector<ExitStatus> statuses)
    : parser_(std::make_unique<Parser>()) {
  std::string footer = "Exit status:";
  for (const ExitStatus& row : statuses)
    footer += (footer.back() == ':' ? " " : ", ") + std::to_string(row.status) + " " + row.meaning;
  parser_->app.name(name);
  parser_->app.description(description);
  parser_->app.footer(footer + ".");
  parser_->statuses = std::move(statuses);
  parser_->app.require_subcommand(1);
}

CommandLine::~CommandLine() = default;

Command CommandLine::add_command(const std::string& name, const std::string& help) {
  parser_->commands.push_back({parser_->app.add_subcommand(name, help), &parser_->chosen});
  return Command(&parser_->commands.back());
}

void CommandLine::add_version(std::function<std::string()> text) {
  const auto ask = [this, text = std::move(text)] {
    parser_->version = text;
    throw CLI::Success();
  };
  parser_->app.add_flag_callback("--version", ask, "Print version, commit, MuJoCo and OpenGL");
}

void CommandLine::add_environment(const std::string& name, const std::string& meaning) {
  parser_->environment.push_back({name, meaning});
}

ProgramText CommandLine::text() const {
  ProgramText text{parser_->app.get_name(),
                   parser_->app.get_description(),
                   parser_->statuses,
                   parser_->environment,
                   {},
                   {}};
  for (CLI::Option* const option : parser_->app.get_options()) text.options.push_back(text_of({option}));
  for (const ParserCommand& command : parser_->commands) {
    if (command.app->get_group().empty()) continue;
    CommandText& row = text.commands.emplace_back(
        CommandText{command.app->get_name(), command.app->get_description(), command.footer, {}});
    row.options.push_back(text_of({command.app->get_help_ptr()}));
    for (const ParserOption& option : command.options) row.options.push_back(text_of(option));
  }
  return text;
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

}  // namespace saccade
