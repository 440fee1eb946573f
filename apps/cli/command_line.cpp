#include "apps/cli/command_line.h"

#include <CLI/CLI.hpp>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <optional>

#include "core/error.h"

namespace saccade::inline v0_1 {
namespace {

CLI::Option& parser(ParserOption* option) { return *reinterpret_cast<CLI::Option*>(option); }
CLI::App& parser(ParserCommand* command) { return *reinterpret_cast<CLI::App*>(command); }
Option option_of(CLI::Option* option) { return Option(reinterpret_cast<ParserOption*>(option)); }

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
  parser(option_).check(CLI::Range(min, max));
  return *this;
}

Option& Option::positive() {
  parser(option_).check(CLI::PositiveNumber);
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

int CommandLine::run(int argc, const char* const* argv) {
  try {
    parser_->app.parse(argc, argv);
    return parser_->chosen();
  } catch (const CLI::ParseError& error) {
    if (parser_->version) {
      std::puts(parser_->version().c_str());
      return 0;
    }
    return parser_->app.exit(error) == 0 ? 0 : 2;
  } catch (const InputError& error) {
    std::fprintf(stderr, "saccade: %s\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "saccade: %s\n", error.what());
    return 1;
  }
}

}  // namespace saccade::inline v0_1
