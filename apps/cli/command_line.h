#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace saccade::inline v0_1 {

/// The parser behind: CLI11, which one file alone includes, since each inclusion costs 20 s of compilation.
struct ParserOption;
struct ParserCommand;

/// One option of a subcommand. Each member returns the option itself.
class Option {
 public:
  explicit Option(ParserOption* option) : option_(option) {}

  Option& required();
  /// The help text shows the value that the variable has now.
  Option& show_default();
  Option& in_range(double min, double max);
  Option& positive();
  Option& one_of(std::vector<std::string> words);
  /// Each value needs the option's name before it, so that no positional argument is taken for a value.
  Option& one_value_each();
  /// The two cannot be given together.
  Option& excludes(const Option& other);

 private:
  ParserOption* option_;
};

/// A subcommand. Variables that options are bound to must outlive the parsing.
class Command {
 public:
  explicit Command(ParserCommand* command, std::function<int()>* chosen)
      : command_(command), chosen_(chosen) {}

  /// An option `--name`, or a positional argument `name`. T: std::string, std::filesystem::path, vectors of them, double,
  /// int, std::int64_t, std::size_t, and std::optional of these.
  template <class T>
  Option option(const std::string& name, T& value, const std::string& help);
  /// The same with a function that reads the text; it throws InputError for bad text.
  Option option(const std::string& name, std::function<void(const std::string&)> read,
                const std::string& help);
  Option flag(const std::string& name, bool& value, const std::string& help);
  void footer(const std::string& text);
  /// Left out of --help.
  void hide();
  /// What the subcommand does; its value is the exit status (0, or 3 for an unmet `expect:`). Bad input is thrown as
  /// InputError (status 2), a failed run as another exception (status 1).
  void action(std::function<int()> action);

 private:
  ParserCommand* command_;
  std::function<int()>* chosen_;
};

/// The command line of the program: subcommands, one of which is chosen.
class CommandLine {
 public:
  CommandLine(const std::string& name, const std::string& description, const std::string& footer);
  CommandLine(const CommandLine&) = delete;
  CommandLine& operator=(const CommandLine&) = delete;
  ~CommandLine();

  [[nodiscard]] Command add_command(const std::string& name, const std::string& help);
  /// `--version` prints what `text` returns.
  void add_version(std::function<std::string()> text);
  /// Parses and carries out the chosen subcommand. Errors go to standard error. Returns the exit status: 0 fine, 1 the run
  /// failed, 2 bad input or usage, or the action's own.
  [[nodiscard]] int run(int argc, const char* const* argv);

 private:
  struct Parser;
  std::unique_ptr<Parser> parser_;
};

}  // namespace saccade::inline v0_1
