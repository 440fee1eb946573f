#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace saccade {

/// The parser behind: CLI11, which one file alone includes, since each inclusion costs 20 s of compilation.
struct ParserOption;
struct ParserCommand;

/// What the completion of a shell offers for a value, beside the option's words.
enum class Offer { nothing, files, files_and_scenarios };

/// An option or positional argument as it was defined, for man pages and the completion of shells.
struct OptionText {
  std::vector<std::string> names;  ///< "-h", "--help"; one without hyphens: of a positional argument
  std::string help;
  std::string type;  ///< "PATH"; empty: a flag
  std::string default_value;
  std::string range;               ///< "in [1, 64]"; empty: not limited
  std::vector<std::string> words;  ///< values that it takes, or some of them
  bool only_words = false;         ///< it takes no others
  Offer offer = Offer::nothing;
  bool required = false;
  bool repeats = false;               ///< takes several values
  std::vector<std::string> excludes;  ///< names of options that cannot be given with it

  [[nodiscard]] bool is_positional() const { return !names.front().starts_with('-'); }
};

struct CommandText {
  std::string name;
  std::string help;
  std::string footer;               ///< empty where the command has none of its own
  std::vector<OptionText> options;  ///< in the order of --help, --help itself first
};

struct ExitStatus {
  int status = 0;
  std::string meaning;
};

struct EnvironmentVariable {
  std::string name;
  std::string meaning;
};

/// The definitions of a command line, without hidden subcommands.
struct ProgramText {
  std::string name;
  std::string help;
  std::vector<ExitStatus> statuses;
  std::vector<EnvironmentVariable> environment;
  std::vector<OptionText> options;  ///< of the program itself
  std::vector<CommandText> commands;
};

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
  /// Completion offers what `words` returns; the option takes other text too.
  Option& offers(std::function<std::vector<std::string>()> words);
  /// Completion offers the names of shipped scenarios, beside files.
  Option& offers_scenarios();
  /// Each value needs the option's name before it, so that no positional argument is taken for a value.
  Option& one_value_each();
  /// The option can stand without a value, which is then "".
  Option& value_optional();
  /// The two cannot be given together.
  Option& excludes(const Option& other);

 private:
  ParserOption* option_;
};

/// A subcommand. Variables that options are bound to must outlive the parsing.
class Command {
 public:
  explicit Command(ParserCommand* command) : command_(command) {}

  /// An option `--name`, or a positional argument `name`. T: std::string, std::filesystem::path, vectors of them, double,
  /// int, std::int64_t, std::size_t, and std::optional of these.
  template <class T>
  Option option(const std::string& name, T& value, const std::string& help);
  /// The same with a function that reads the text; it throws InputError for bad text.
  Option option(const std::string& name, const std::function<void(const std::string&)>& read,
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
};

/// The command line of the program: subcommands, one of which is chosen.
class CommandLine {
 public:
  /// --help ends with the statuses.
  CommandLine(const std::string& name, const std::string& description, std::vector<ExitStatus> statuses);
  CommandLine(const CommandLine&) = delete;
  CommandLine& operator=(const CommandLine&) = delete;
  ~CommandLine();

  [[nodiscard]] Command add_command(const std::string& name, const std::string& help);
  /// `--version` prints what `text` returns.
  void add_version(std::function<std::string()> text);
  /// A variable that the program reads, for its man page.
  void add_environment(const std::string& name, const std::string& meaning);
  [[nodiscard]] ProgramText text() const;
  /// Parses and carries out the chosen subcommand. Errors go to standard error. Returns the exit status: 0 fine, 1 the run
  /// failed, 2 bad input or usage, or the action's own.
  [[nodiscard]] int run(int argc, const char* const* argv);

 private:
  struct Parser;
  std::unique_ptr<Parser> parser_;
};

}  // namespace saccade
