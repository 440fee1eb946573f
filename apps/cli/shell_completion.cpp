#include "apps/cli/shell_completion.h"

namespace saccade {
namespace {

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : " ") + word;
  return text;
}

/// Text within single quotes of a shell.
std::string quoted(const std::string& text) {
  std::string result = "'";
  for (const char c : text) result += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return result + "'";
}

std::string with_backslashes(const std::string& text, const std::string& special) {
  std::string result;
  for (const char c : text) {
    if (special.find(c) != std::string::npos) result += '\\';
    result += c;
  }
  return result;
}

/// A part of a script that is the same for every program but for its name.
std::string named(std::string script, const std::string& name) {
  const std::string placeholder = "PROGRAM";
  for (std::size_t at = script.find(placeholder); at != std::string::npos; at = script.find(placeholder, at))
    script.replace(at, placeholder.size(), name);
  return script;
}

std::string option_names(const std::vector<OptionText>& options) {
  std::vector<std::string> names;
  for (const OptionText& option : options) {
    if (!option.is_positional()) names.insert(names.end(), option.names.begin(), option.names.end());
  }
  return joined(names);
}

/// "run 1" or "test [0-9]*" for positional arguments, "run --out" for options: patterns of Bash's `case`.
std::string bash_places(const OptionText& option, const std::string& command, int position) {
  if (option.is_positional() && option.repeats) return quoted(command + " ") + "[0-9]*";
  if (option.is_positional()) return quoted(command + " " + std::to_string(position));
  std::string places;
  for (const std::string& name : option.names)
    places += (places.empty() ? "" : " | ") + quoted(command + " " + name);
  return places;
}

/// The cases of _PROGRAM_value.
std::string bash_values(const CommandText& command) {
  std::string text;
  int position = 0;
  for (const OptionText& option : command.options) {
    if (option.type.empty()) continue;
    if (option.is_positional()) ++position;
    std::string value = quoted(option.offer == Offer::nothing ? "words" : "files");
    if (option.offer == Offer::files_and_scenarios) {
      value = "\"files $_PROGRAM_scenarios\"";
    } else if (!option.words.empty()) {
      value = quoted("words " + joined(option.words));
    }
    text += "    " + bash_places(option, command.name, position) + ") value=" + value + " ;;\n";
  }
  return text;
}

const char* const bash_function = R"bash(
_PROGRAM() {
  local IFS=$' \t\n' command= options= value= before= word i kind
  local -i position=0
  COMPREPLY=()
  # Bash divides --name=value into three words.
  for ((i = 1; i < COMP_CWORD; i++)); do
    word=${COMP_WORDS[i]}
    if [[ $word == '=' ]]; then
      before=${before:-=}
    elif [[ $before ]]; then
      before=
    elif [[ $word == -* ]]; then
      _PROGRAM_value "$command $word"
      if [[ $value ]]; then before=$word; fi
    elif [[ ! $command ]]; then
      command=$word
    else
      position+=1
    fi
  done
  word=${COMP_WORDS[COMP_CWORD]}
  if [[ $word == '=' ]]; then
    before=${before:-=}
    word=
  fi
  if [[ $before ]]; then
    _PROGRAM_value "$command $before"
  elif [[ $word == -* ]]; then
    _PROGRAM_options "$command"
    value="words $options"
  elif [[ ! $command ]]; then
    value="words $_PROGRAM_commands"
  else
    _PROGRAM_value "$command $((position + 1))"
  fi
  kind=${value%% *}
  mapfile -t COMPREPLY < <(compgen -W "${value#"$kind"}" -- "$word")
  if [[ $kind == files ]]; then
    mapfile -t -O "${#COMPREPLY[@]}" COMPREPLY < <(compgen -f -- "$word")
    compopt -o filenames 2>/dev/null
  fi
  return 0
}

complete -F _PROGRAM PROGRAM
)bash";

/// An option as _arguments takes it, without its value: what cannot stand beside it, name, help.
std::string zsh_option(const OptionText& option, const std::string& name) {
  std::vector<std::string> excluded;
  for (const std::string& other : option.excludes) {
    if (other.starts_with('-')) excluded.push_back(other);
  }
  if (name == "-h" || name == "--help" || name == "--version") excluded = {"-", ":", "*"};  // all others
  std::string text = option.repeats ? "*" : "";
  if (!excluded.empty()) text += "(" + joined(excluded) + ")";
  text += name;
  if (!option.type.empty()) text += "=";
  return text + "[" + with_backslashes(option.help, "[]:\\") + "]";
}

/// ":message:action" of a value.
std::string zsh_value(const OptionText& option) {
  std::string action;
  if (option.offer == Offer::files_and_scenarios) {
    action = "_PROGRAM_scenarios";
  } else if (option.offer == Offer::files) {
    action = "_files";
  } else if (!option.words.empty()) {
    action = "(" + joined(option.words) + ")";
  }
  return ":" + (option.is_positional() ? option.names.front() : option.type) + ":" + action;
}

/// The arguments of _arguments, one a line.
std::string zsh_arguments(const std::vector<OptionText>& options, const std::string& indent) {
  std::string text;
  int position = 0;
  const auto add = [&](const std::string& argument) { text += " \\\n" + indent + quoted(argument); };
  for (const OptionText& option : options) {
    if (option.is_positional()) {
      ++position;
      const std::string place = option.repeats    ? "*"
                                : option.required ? std::to_string(position)
                                                  : std::to_string(position) + ":";
      add(place + zsh_value(option));
      continue;
    }
    for (const std::string& name : option.names)
      add(zsh_option(option, name) + (option.type.empty() ? "" : zsh_value(option)));
  }
  return text;
}

}  // namespace

std::string bash_completion(const ProgramText& program, const std::vector<std::string>& scenarios) {
  std::vector<std::string> commands;
  std::string options = "    '') options=" + quoted(option_names(program.options)) + " ;;\n";
  std::string values;
  for (const CommandText& command : program.commands) {
    commands.push_back(command.name);
    options += "    " + command.name + ") options=" + quoted(option_names(command.options)) + " ;;\n";
    values += bash_values(command);
  }
  return named(
      "# Completion of PROGRAM for bash, made by PROGRAM command-pages.\n\n_PROGRAM_commands=" +
          quoted(joined(commands)) + "\n_PROGRAM_scenarios=" + quoted(joined(scenarios)) +
          "\n\n# The options of a subcommand.\n_PROGRAM_options() {\n  case $1 in\n" + options +
          "    *) options= ;;\n  esac\n}\n\n# What stands at \"COMMAND --OPTION\" or \"COMMAND POSITION\": "
          "\"files\" or \"words\", then words; nothing behind a flag.\n"
          "_PROGRAM_value() {\n  case $1 in\n" +
          values + "    *) value= ;;\n  esac\n}\n" + bash_function,
      program.name);
}

std::string zsh_completion(const ProgramText& program, const std::vector<std::string>& scenarios) {
  std::string commands;
  std::string cases;
  for (const CommandText& command : program.commands) {
    commands += "        " + quoted(command.name + ":" + command.help) + "\n";
    cases += "        " + command.name + ")\n          _arguments -S" +
             zsh_arguments(command.options, "            ") + "\n          ;;\n";
  }
  return named(
      "#compdef PROGRAM\n# Completion of PROGRAM for zsh, made by PROGRAM command-pages.\n\n"
      "_PROGRAM_scenarios() {\n  _alternative " +
          quoted("scenarios:shipped scenario:(" + joined(scenarios) + ")") +
          " 'files:file:_files'\n}\n\n_PROGRAM() {\n  local context state state_descr line\n"
          "  local -A opt_args\n  _arguments -C" +
          zsh_arguments(program.options, "    ") +
          " \\\n    '1:command:->command' \\\n    '*::argument:->argument'\n"
          "  case $state in\n    command)\n      local -a commands=(\n" +
          commands +
          "      )\n      _describe -t commands command commands\n      ;;\n    argument)\n"
          "      case $words[1] in\n" +
          cases + "      esac\n      ;;\n  esac\n}\n\n_PROGRAM \"$@\"\n",
      program.name);
}

}  // namespace saccade
