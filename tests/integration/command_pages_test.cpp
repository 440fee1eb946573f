// The man pages and the completion of shells, made from the definitions of the command line.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "tests/integration/run_shell.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::IsSupersetOf;
using testing::UnorderedElementsAreArray;

using Words = std::vector<std::string>;

const std::string program = "'" SACCADE_BINARY "' ";

Words lines_of(const std::string& text) {
  Words lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

/// The first words of the indented lines below `heading` in the text of --help: "-h,--help", "--out", "scenario".
Words names_below(const std::string& heading, const std::string& help) {
  Words names;
  bool inside = false;
  for (const std::string& line : lines_of(help)) {
    if (!line.starts_with(' ')) inside = line == heading;
    if (inside && line.starts_with("  ") && line.size() > 2 && line[2] != ' ')
      names.push_back(line.substr(2, line.find(' ', 2) - 2));
  }
  return names;
}

std::string help_of(const std::string& command) { return run_shell(program + command + " --help").text; }

Words commands_of_help() { return names_below("Subcommands:", help_of("")); }

/// "-h,--help" is two names.
Words split_names(const Words& options) {
  Words names;
  for (const std::string& option : options) {
    std::istringstream stream(option);
    for (std::string name; std::getline(stream, name, ',');) names.push_back(name);
  }
  return names;
}

std::string roff(const std::string& text) { return std::regex_replace(text, std::regex("-"), "\\-"); }

class CommandPages : public testing::Test {
 protected:
  void SetUp() override {
    const Outcome outcome = run_shell(program + "command-pages '" + (folder_ / "share").string() + "'");
    ASSERT_EQ(outcome.status, 0) << outcome.text;
  }

  [[nodiscard]] fs::path file(const std::string& name) const { return folder_ / "share" / name; }
  [[nodiscard]] fs::path page(const std::string& name) const { return file("man/man1/" + name + ".1"); }

  /// What Bash offers for the last of the words, in the folder of the test.
  [[nodiscard]] Words offered(const std::string& words) const {
    const Outcome outcome =
        run_shell("cd '" + (folder_ / "").string() +
                  "' && bash --norc -c '. share/bash-completion/completions/saccade; "
                  "set -u; COMP_WORDS=(\"$@\"); COMP_CWORD=$(($# - 1)); _saccade; "
                  "((${#COMPREPLY[@]} == 0)) || printf \"%s\\n\" \"${COMPREPLY[@]}\"' bash saccade " +
                  words);
    EXPECT_EQ(outcome.status, 0) << outcome.text;
    return lines_of(outcome.text);
  }

  TempFolder folder_;
};

TEST_F(CommandPages, EveryCommandOptionAndArgumentOfHelpIsInItsPageAndNoOther) {
  const Words commands = commands_of_help();
  ASSERT_THAT(commands, IsSupersetOf({"run", "fit-sensor", "migrate"}));
  std::size_t files = 0;
  for (const auto& entry : fs::directory_iterator(file("man/man1"))) files += entry.is_regular_file() ? 1 : 0;
  EXPECT_EQ(files, commands.size() + 1);
  for (const std::string& command : commands) {
    const std::string text = bytes_of(page("saccade-" + command));
    for (const char* section : {".SH NAME\n", ".SH SYNOPSIS\n", ".SH DESCRIPTION\n", ".SH OPTIONS\n",
                                ".SH EXIT STATUS\n", ".SH SEE ALSO\n"})
      EXPECT_THAT(text, HasSubstr(section)) << command;
    const std::string help = help_of(command);
    const Words options = names_below("Options:", help);
    EXPECT_FALSE(options.empty()) << command;
    for (const std::string& name : split_names(options))
      EXPECT_THAT(text, HasSubstr("\\fB" + roff(name) + "\\fR")) << command;
    const Words arguments = names_below("Positionals:", help);
    for (const std::string& name : arguments)
      EXPECT_THAT(text, HasSubstr("\n\\fI" + roff(name) + "\\fR\n")) << command;
    const std::regex entry("\n\\.TP\n\\\\f[BI]");
    EXPECT_EQ(static_cast<std::size_t>(std::distance(std::sregex_iterator(text.begin(), text.end(), entry),
                                                     std::sregex_iterator())),
              options.size() + arguments.size())
        << command;
    EXPECT_THAT(bytes_of(page("saccade")), HasSubstr(".BR " + roff("saccade-" + command) + " (1)\n"));
  }
}

TEST_F(CommandPages, APageHasDefaultsChoicesRangesAndWhereShippedScenariosAre) {
  const std::string convert = bytes_of(page("saccade-convert"));
  EXPECT_THAT(convert, HasSubstr("One of both, on, off; by default both.\n"));
  EXPECT_THAT(bytes_of(page("saccade-sweep")), HasSubstr("A number in [1, 1e+05].\n"));
  EXPECT_THAT(bytes_of(page("saccade-sweep")), HasSubstr("Not together with sweep.\n"));
  const std::string run = bytes_of(page("saccade-run"));
  EXPECT_THAT(run, HasSubstr(".SH ENVIRONMENT\n.TP\n.B SACCADE_DATA\n"));
  EXPECT_THAT(run, HasSubstr(".SH FILES\n.TP\n.I share/saccade/scenarios/\n"));
  EXPECT_THAT(run, HasSubstr(".TP\n.B 3\nan \\fBexpect:\\fR was not met or a figure has changed.\n"));
  EXPECT_THAT(bytes_of(page("saccade-label")),
              HasSubstr(".BR saccade\\-detect (1),\n.BR saccade\\-score (1)\n"));
}

TEST_F(CommandPages, FormattersAndAManPageCheckerFindNothingWrong) {
  const bool has_groff = run_shell("command -v groff").status == 0;
  const bool has_mandoc = run_shell("command -v mandoc").status == 0;
  const std::string pages = "'" + file("man/man1").string() + "'/*.1";
  if (has_groff) {
    EXPECT_EQ(run_shell("for page in " + pages + "; do groff -man -ww -Tutf8 -z \"$page\"; done").text, "");
  }
  if (has_mandoc) {
    const Outcome checked = run_shell("mandoc -T lint -W warning " + pages);
    EXPECT_EQ(checked.status, 0) << checked.text;
  }
  if (!has_groff || !has_mandoc)
    GTEST_SKIP() << "SKIPPED in part: " << (has_groff ? "" : "groff ") << (has_mandoc ? "" : "mandoc ")
                 << "is not installed; Debian's packages groff-base and mandoc";
}

TEST_F(CommandPages, BashOffersCommandsOptionsAndTheirValues) {
  EXPECT_THAT(offered("de"), UnorderedElementsAreArray(Words{"detect", "deploy"}));
  EXPECT_THAT(offered("''"), UnorderedElementsAreArray(commands_of_help()));
  EXPECT_THAT(offered("--v"), ElementsAre("--version"));
  EXPECT_THAT(offered("run --se"), ElementsAre("--seed", "--set"));
  EXPECT_THAT(offered("run --seed ''"), IsEmpty());
  EXPECT_THAT(offered("convert in out --polarity ''"), ElementsAre("both", "on", "off"));
  EXPECT_THAT(offered("convert in out --polarity = o"), ElementsAre("on", "off"));
  EXPECT_THAT(offered("convert in out --polarity ="), ElementsAre("both", "on", "off"));
  EXPECT_THAT(offered("emulate --preset dvs"), Contains("dvs128"));
  EXPECT_THAT(offered("sweep --engine s"), ElementsAre("slurm"));
  EXPECT_THAT(offered("keys detectors.be"), ElementsAre("detectors.best"));
  EXPECT_THAT(offered("nonsense ''"), IsEmpty());
  for (const std::string& command : commands_of_help()) {
    EXPECT_THAT(offered(command + " -"),
                UnorderedElementsAreArray(split_names(names_below("Options:", help_of(command)))))
        << command;
  }
}

TEST_F(CommandPages, BashOffersScenariosAndFilesAtTheirPlaces) {
  folder_.write("my recording.aedat", "");
  folder_.write("look_here.yaml", "");
  EXPECT_THAT(offered("run look"), ElementsAre("look_at_ball", "look_at_mug", "look_here.yaml"));
  EXPECT_THAT(offered("run --force look_at_b"), ElementsAre("look_at_ball"));
  EXPECT_THAT(offered("run --seed 3 look_at_b"), ElementsAre("look_at_ball"));
  EXPECT_THAT(offered("run --set a = b look_at_b"), ElementsAre("look_at_ball"));
  EXPECT_THAT(offered("test look_at_ball gaze_circle look_at_m"), ElementsAre("look_at_mug"));
  EXPECT_THAT(offered("view --seed 3 gaze_c"), ElementsAre("gaze_circle"));
  EXPECT_THAT(offered("info my"), ElementsAre("my recording.aedat"));
  EXPECT_THAT(offered("run look_at_ball --out sha"), ElementsAre("share"));
  EXPECT_THAT(offered("run look_at_ball ''"), IsEmpty());  // one scenario alone
  EXPECT_THAT(offered("info look_at"), IsEmpty());         // no scenario
}

TEST_F(CommandPages, ZshReadsItsCompletionWhichHasEveryOption) {
  const std::string text = bytes_of(file("zsh/vendor-completions/_saccade"));
  EXPECT_TRUE(text.starts_with("#compdef saccade\n"));
  for (const std::string& command : commands_of_help()) {
    const std::size_t begin = text.find("\n        " + command + ")\n");
    ASSERT_NE(begin, std::string::npos) << command;
    const std::string part = text.substr(begin, text.find("\n          ;;\n", begin) - begin);
    for (const std::string& name : split_names(names_below("Options:", help_of(command))))
      EXPECT_THAT(part, testing::AnyOf(HasSubstr(name + "["), HasSubstr(name + "=["))) << command;
  }
  if (run_shell("command -v zsh").status != 0)
    GTEST_SKIP() << "SKIPPED in part: zsh is not installed; it would read the script";
  const Outcome read = run_shell("zsh -n '" + file("zsh/vendor-completions/_saccade").string() + "'");
  EXPECT_EQ(read.status, 0) << read.text;
  EXPECT_EQ(read.text, "");
}

}  // namespace
}  // namespace saccade
