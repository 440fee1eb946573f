#include "apps/cli/man_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

namespace saccade {
namespace {

/// Text without what troff takes for a command. `code` between backticks is bold.
std::string escaped(const std::string& text) {
  std::string roff;
  bool is_code = false;
  for (const char c : text) {
    switch (c) {
      case '\\':
        roff += "\\e";
        break;
      case '-':
        roff += "\\-";
        break;
      case '\'':
        roff += "\\(aq";
        break;
      case '~':
        roff += "\\(ti";
        break;
      case '^':
        roff += "\\(ha";
        break;
      case '`':
        is_code = !is_code;
        roff += is_code ? "\\fB" : "\\fR";
        break;
      default:
        roff += c;
    }
  }
  return roff;
}

/// A paragraph, one sentence a line. A line that begins with a dot would be a command.
std::string paragraph(const std::string& text) {
  std::string lines;
  const std::string roff = escaped(text);
  for (std::size_t begin = 0; begin < roff.size();) {
    const std::size_t dot = roff.find(". ", begin);
    const std::size_t end = dot == std::string::npos ? roff.size() : dot + 1;
    lines += (roff[begin] == '.' ? "\\&" : "") + roff.substr(begin, end - begin) + "\n";
    begin = end + 1;
  }
  return lines;
}

/// Lines of `text` as paragraphs.
std::string paragraphs(const std::string& text) {
  std::string roff;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    if (end > begin) roff += (roff.empty() ? "" : ".PP\n") + paragraph(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return roff;
}

std::string with_dot(std::string text) {
  if (!text.empty() && text.back() != '.') text += '.';
  return text;
}

std::string page_name(const ProgramText& program, const CommandText& command) {
  return program.name + "-" + command.name;
}

std::string header(const std::string& name, const std::string& help, const ProgramText& program,
                   const std::string& version, const std::string& date) {
  std::string title = escaped(name);
  std::ranges::transform(title, title.begin(),
                         [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  std::string line = help;  // "One closed-loop run": one line without a dot
  if (line.ends_with('.')) line.pop_back();
  return fmt::format(
      ".\\\" Made by {0} command-pages.\n.TH {1} 1 {2} \"{0} {3}\" \"User Commands\"\n"
      ".SH NAME\n{4} \\- {5}\n",
      program.name, title, date, version, escaped(name), escaped(line));
}

/// "One of a, b; by default a; in [1, 2]. Not together with --x."
std::string conditions(const OptionText& option) {
  std::string text;
  const auto add = [&](const std::string& part) { text += (text.empty() ? "" : "; ") + part; };
  if (option.only_words && !option.words.empty()) {
    std::string words;
    for (const std::string& word : option.words) words += (words.empty() ? "" : ", ") + word;
    add("one of " + words);
  }
  if (!option.range.empty()) add("a number " + option.range);
  if (!option.default_value.empty()) add("by default " + option.default_value);
  if (option.repeats) add(option.is_positional() ? "one or several" : "can be given several times");
  if (option.required && !option.is_positional()) add("must be given");
  for (const std::string& other : option.excludes) add("not together with " + other);
  if (!text.empty()) text.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(text.front())));
  return with_dot(text);
}

std::string entry(const OptionText& option) {
  std::string title;
  for (const std::string& name : option.names) {
    if (!title.empty()) title += ", ";
    title += option.is_positional() ? "\\fI" + escaped(name) + "\\fR" : "\\fB" + escaped(name) + "\\fR";
  }
  if (!option.is_positional() && !option.type.empty()) title += " \\fI" + escaped(option.type) + "\\fR";
  return ".TP\n" + title + "\n" + paragraph(with_dot(option.help)) + paragraph(conditions(option));
}

std::string synopsis(const CommandText& command) {
  std::string line;
  for (const OptionText& option : command.options) {
    if (!option.is_positional()) continue;
    std::string name = "\\fI" + escaped(option.names.front()) + "\\fR" + (option.repeats ? " ..." : "");
    line += option.required ? " " + name : " [" + name + "]";
  }
  return line;
}

std::string exit_status(const ProgramText& program) {
  std::string text = ".SH EXIT STATUS\n";
  for (const ExitStatus& row : program.statuses)
    text += fmt::format(".TP\n.B {}\n{}", row.status, paragraph(with_dot(row.meaning)));
  return text;
}

std::string environment(const std::vector<EnvironmentVariable>& variables) {
  std::string text;
  for (const EnvironmentVariable& variable : variables)
    text += ".TP\n.B " + variable.name + "\n" + paragraph(variable.meaning);
  return text.empty() ? "" : ".SH ENVIRONMENT\n" + text;
}

bool offers_scenarios(const CommandText& command) {
  return std::ranges::any_of(
      command.options, [](const OptionText& option) { return option.offer == Offer::files_and_scenarios; });
}

const char* const shipped_scenarios_entry =
    ".TP\n.I share/saccade/scenarios/\nShipped scenarios.\nA name such as look_at_ball stands for its file "
    "there, where no file of that name is in the current folder.\n";

/// Other subcommands that the texts of one name: "`detect --truth`", "saccade info".
std::vector<std::string> mentioned(const ProgramText& program, const CommandText& command) {
  std::string text = command.help + "\n" + command.footer;
  for (const OptionText& option : command.options) text += "\n" + option.help;
  std::vector<std::string> pages;
  for (const CommandText& other : program.commands) {
    if (other.name == command.name) continue;
    const std::string name = other.name;
    if (text.find("`" + name + "`") != std::string::npos ||
        text.find("`" + name + " ") != std::string::npos ||
        text.find(program.name + " " + name) != std::string::npos)
      pages.push_back(page_name(program, other));
  }
  return pages;
}

std::string see_also(const std::vector<std::string>& pages) {
  std::string text = ".SH SEE ALSO\n";
  for (std::size_t i = 0; i < pages.size(); ++i)
    text += ".BR " + escaped(pages[i]) + " (1)" + (i + 1 < pages.size() ? ",\n" : "\n");
  return text;
}

std::string page_of(const ProgramText& program, const CommandText& command, const std::string& version,
                    const std::string& date) {
  std::string text = header(page_name(program, command), command.help, program, version, date);
  text += ".SH SYNOPSIS\n\\fB" + program.name + " " + escaped(command.name) + "\\fR [\\fIOPTION\\fR ...]" +
          synopsis(command) + "\n";
  text += ".SH DESCRIPTION\n" + paragraph(with_dot(command.help));
  if (!command.footer.empty()) text += ".PP\n" + paragraphs(command.footer);
  std::string arguments;
  std::string options;
  for (const OptionText& option : command.options)
    (option.is_positional() ? arguments : options) += entry(option);
  if (!arguments.empty()) text += ".SH ARGUMENTS\n" + arguments;
  text += ".SH OPTIONS\n" + options + exit_status(program);
  std::vector<std::string> pages = {program.name};
  for (std::string& page : mentioned(program, command)) pages.push_back(std::move(page));
  if (offers_scenarios(command)) {
    text += environment(program.environment) + ".SH FILES\n" + shipped_scenarios_entry;
  }
  return text + see_also(pages);
}

std::string page_of(const ProgramText& program, const std::string& version, const std::string& date) {
  std::string text = header(program.name, program.help, program, version, date);
  text += fmt::format(
      ".SH SYNOPSIS\n\\fB{0}\\fR \\fICOMMAND\\fR [\\fIOPTION\\fR ...] [\\fIARGUMENT\\fR ...]\n.br\n"
      "\\fB{0}\\fR \\fB\\-\\-help\\fR | \\fB\\-\\-version\\fR\n",
      program.name);
  text += ".SH DESCRIPTION\n" + paragraph(with_dot(program.help));
  text += paragraph("`" + program.name + " COMMAND --help` prints the options of a command.");
  text += ".SH COMMANDS\n";
  std::vector<std::string> pages;
  for (const CommandText& command : program.commands) {
    pages.push_back(page_name(program, command));
    text += ".TP\n.BR " + escaped(pages.back()) + " (1)\n" + paragraph(with_dot(command.help));
  }
  text += ".SH OPTIONS\n";
  for (const OptionText& option : program.options) text += entry(option);
  text += exit_status(program) + environment(program.environment) + ".SH FILES\n" + shipped_scenarios_entry;
  text += ".TP\n.I share/saccade/models/\nModels of the head and the hand.\n";
  text += ".TP\n.I share/doc/saccade/docs/\nThe documentation; these pages name its files docs/NAME.md.\n";
  text += ".PP\nThese folders are in the same tree as the folder bin/ of the program.\n";
  return text + see_also(pages);
}

}  // namespace

std::map<std::string, std::string> man_pages(const ProgramText& program, const std::string& version,
                                             const std::string& date) {
  std::map<std::string, std::string> pages = {{program.name + ".1", page_of(program, version, date)}};
  for (const CommandText& command : program.commands)
    pages[page_name(program, command) + ".1"] = page_of(program, command, version, date);
  return pages;
}

}  // namespace saccade
