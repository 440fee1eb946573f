#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <bit>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <ostream>

#include "config/yaml_reader.h"
#include "config/yaml_tree.h"
#include "config/yaml_writer.h"
#include "core/random.h"

namespace saccade {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

struct WindowConfig {
  std::int64_t events = 1500;
  bool directed = true;
  friend bool operator==(const WindowConfig&, const WindowConfig&) = default;
};

void describe(FieldVisitor& v, WindowConfig& config) {
  v.integer("events", config.events, {1, 1e6}, "events in the window");
  v.boolean("directed", config.directed, "vote along the flow");
}

/// One field of every kind.
struct Config {
  std::string name = "nameless";
  std::int64_t seed = 1;
  double duration_s = 4.0;
  double low_px = 10.0;
  double high_px = 35.0;
  std::string clutter = "textured";
  std::array<double, 3> position_m = {-0.4, 0.0, 0.3};
  std::array<double, 3> radii_px = {5.0, 6.0, 7.0};
  std::vector<std::array<double, 2>> corners_m = {};
  WindowConfig window;
  friend bool operator==(const Config&, const Config&) = default;
};

constexpr Range any_number{};

void describe(FieldVisitor& v, Config& config) {
  v.text("name", config.name, "what it is called");
  v.integer("seed", config.seed, {0, 9e18}, "of all randomness");
  v.real("duration_s", config.duration_s, {0.01, 3600}, "how long it takes");
  v.real("low_px", config.low_px, any_number, "smallest radius");
  v.real("high_px", config.high_px, any_number, "largest radius");
  v.require(config.low_px <= config.high_px, "high_px", text_of(config.high_px), "at least low_px");
  v.choice("clutter", config.clutter, {"textured", "rectilinear"}, "what stands around");
  v.reals("position_m", config.position_m, {-10, 10}, "where");
  v.reals("radii_px", config.radii_px, {1, 100}, "which");
  v.points("corners_m", config.corners_m, any_number, "the way");
  v.section(
      "window", [&](FieldVisitor& inner) { describe(inner, config.window); }, "which events count");
}

Config read(std::string_view yaml, const std::vector<std::string>& sets = {},
            std::vector<std::string> required = {}) {
  YamlTree tree = parse_yaml(yaml, "a.yaml");
  for (const std::string& set : sets) set_value(tree, set);
  return read_config<Config>(tree, {}, std::move(required));
}

/// The lines of the InputError; empty when nothing is wrong.
std::vector<std::string> complaints(std::string_view yaml, const std::vector<std::string>& sets = {},
                                    std::vector<std::string> required = {}) {
  std::vector<std::string> lines;
  try {
    static_cast<void>(read(yaml, sets, std::move(required)));
  } catch (const InputError& error) {
    for (const Problem& problem : error.problems()) lines.push_back(problem.text());
  }
  return lines;
}

TEST(YamlConfig, ReadsEveryKindOfFieldAndLeavesTheDefaultsOfAbsentOnes) {
  const Config config = read(
      "# a comment\n"
      "name: \"07\"\n"
      "seed: 9007199254740993\n"
      "duration_s: 1.5e-1\n"
      "clutter: rectilinear\n"
      "position_m: [-1, +.5, 2.]\n"
      "corners_m:\n"
      "  - [0, 0.1]\n"
      "  - [0.2, 0.3]\n"
      "window: {directed: false}\n");
  Config expected;
  expected.name = "07";
  expected.seed = 9007199254740993;  // has no double
  expected.duration_s = 0.15;
  expected.clutter = "rectilinear";
  expected.position_m = {-1.0, 0.5, 2.0};
  expected.corners_m = {{0.0, 0.1}, {0.2, 0.3}};
  expected.window.directed = false;
  EXPECT_EQ(config, expected);
}

struct Mistake {
  const char* name;
  std::string yaml;
  std::string message;
};

std::ostream& operator<<(std::ostream& out, const Mistake& mistake) { return out << mistake.name; }

class YamlMistake : public testing::TestWithParam<Mistake> {};

TEST_P(YamlMistake, IsTheOnlyComplaintWithItsPlace) {
  EXPECT_THAT(complaints(GetParam().yaml), ElementsAre(GetParam().message));
}

const std::string duration = "a.yaml:2: duration_s: found ";
const std::string number = ", expected a finite number in [0.01, 3600]";

INSTANTIATE_TEST_SUITE_P(
    Values, YamlMistake,
    testing::Values(
        Mistake{"octal", "name: a\nduration_s: 010", duration + "010 (leading zero)" + number},
        Mistake{"hexadecimal", "name: a\nduration_s: 0x10", duration + "0x10 (not decimal)" + number},
        Mistake{"nan", "name: a\nduration_s: .nan", duration + ".nan (not finite)" + number},
        Mistake{"infinity", "name: a\nduration_s: -.INF", duration + "-.INF (not finite)" + number},
        Mistake{"overflow", "name: a\nduration_s: 1e999", duration + "1e999 (beyond a double)" + number},
        Mistake{"underflow", "name: a\nduration_s: 1e-999", duration + "1e-999 (beyond a double)" + number},
        Mistake{"outOfRange", "name: a\nduration_s: 0", duration + "0" + number},
        Mistake{"twoPoints", "name: a\nduration_s: 1.2.3", duration + "1.2.3" + number},
        Mistake{"unitInValue", "name: a\nduration_s: 4 s", duration + "4 s" + number},
        Mistake{"underscore", "name: a\nduration_s: 1_000", duration + "1_000" + number},
        Mistake{"sexagesimal", "name: a\nduration_s: 1:30", duration + "1:30" + number},
        Mistake{"numberInQuotes", "name: a\nduration_s: \"4\"",
                duration + "\"4\" (in quotes, so it is text)" + number},
        Mistake{"listForNumber", "name: a\nduration_s: [4]", duration + "a list" + number},
        Mistake{"mapForNumber", "name: a\nduration_s:\n  s: 4", duration + "a block of keys" + number},
        Mistake{"nothingForNumber", "name: a\nduration_s:", duration + "nothing" + number},
        Mistake{"nullForNumber", "name: a\nduration_s: ~", duration + "nothing" + number},
        Mistake{"fractionForWhole", "seed: 1.0",
                "a.yaml:1: seed: found 1.0, expected a whole number in [0, 9e+18]"},
        Mistake{"exponentForWhole", "seed: 1e3",
                "a.yaml:1: seed: found 1e3, expected a whole number in [0, 9e+18]"},
        Mistake{"wholeTooLong", "seed: 99999999999999999999",
                "a.yaml:1: seed: found 99999999999999999999, expected a whole number in [0, 9e+18]"},
        Mistake{"yesForBoolean", "window: {directed: yes}",
                "a.yaml:1: window.directed: found yes, expected true or false"},
        Mistake{"capitalBoolean", "window: {directed: True}",
                "a.yaml:1: window.directed: found True, expected true or false"},
        Mistake{"quotedBoolean", "window: {directed: 'true'}",
                "a.yaml:1: window.directed: found \"true\", expected true or false"},
        Mistake{"numberForText", "name: 7",
                "a.yaml:1: name: found 7, expected text, in quotes if this is meant"},
        Mistake{"octalForText", "name: 007",
                "a.yaml:1: name: found 007, expected text, in quotes if this is meant"},
        Mistake{"listForText", "name: [a]", "a.yaml:1: name: found a list, expected text"},
        Mistake{"unknownChoice", "clutter: textures",
                "a.yaml:1: clutter: found textures, expected one of textured, rectilinear"},
        Mistake{"shortList", "position_m: [1, 2]",
                "a.yaml:1: position_m: found a list of 2, expected a list of 3 finite numbers in [-10, 10]"},
        Mistake{"numberForList", "position_m: 1",
                "a.yaml:1: position_m: found 1, expected a list of 3 finite numbers in [-10, 10]"},
        Mistake{"badElement", "position_m:\n- 1\n- .nan\n- 3",
                "a.yaml:3: position_m[1]: found .nan (not finite), expected a finite number in [-10, 10]"},
        Mistake{"shortPoint", "corners_m:\n- [1, 2]\n- [1]",
                "a.yaml:3: corners_m[1]: found a list of 1, expected a list of 2 finite numbers"},
        Mistake{"pointsNotNested", "corners_m: [1]",
                "a.yaml:1: corners_m[0]: found 1, expected a list of 2 finite numbers"},
        Mistake{"numberForBlock", "window: 5", "a.yaml:1: window: found 5, expected a block of keys"},
        Mistake{"nothingForBlock", "window:\nname: a",
                "a.yaml:1: window: found nothing, expected a block of keys"},
        Mistake{"brokenCondition", "low_px: 40\nhigh_px: 30",
                "a.yaml:2: high_px: found 30, expected at least low_px"}));

INSTANTIATE_TEST_SUITE_P(
    Structure, YamlMistake,
    testing::Values(
        Mistake{
            "misspelt", "seed: 1\ndurations_s: 4",
            "a.yaml:2: durations_s: found an unknown key, expected a known key; did you mean duration_s?"},
        Mistake{"unitForgotten", "position: [1, 2, 3]",
                "a.yaml:1: position: found an unknown key, expected a known key; did you mean position_m?"},
        Mistake{"letterSwapped", "window: {evnets: 3}",
                "a.yaml:1: window.evnets: found an unknown key, expected a known key; did you mean events?"},
        Mistake{"unlikeAnything", "window:\n  colour: 3",
                "a.yaml:2: window.colour: found an unknown key, expected one of events, directed"},
        Mistake{"twice", "seed: 1\nname: a\nseed: 2",
                "a.yaml:3: seed: found the key a second time, expected each key once (first on line 1)"},
        Mistake{
            "twiceInBlock", "window:\n  events: 1\n  'events': 2",
            "a.yaml:3: window.events: found the key a second time, expected each key once (first on line 2)"},
        Mistake{"anchor", "seed: &a 1", "a.yaml:1: seed: found an anchor (&), expected the value alone"},
        Mistake{"tag", "name: !!str 5",
                "a.yaml:1: name: found the tag tag:yaml.org,2002:str, expected the value alone"},
        Mistake{"tagOnList", "position_m: !vector [1, 2, 3]",
                "a.yaml:1: position_m: found the tag !vector, expected the value alone"},
        Mistake{"directive", "%YAML 1.2\n---\nseed: 1",
                "a.yaml:1: found a directive (%), expected a file without directives"},
        Mistake{"secondDocument", "seed: 1\n---\nseed: 2",
                "a.yaml:2: found a second document, expected one document in a file"},
        Mistake{"listAsKey", "seed: 1\n? [a]\n: 2",
                "a.yaml:2: found a list as a key, expected a word as a key"},
        Mistake{"noKey", "seed: 1\n: 2", "a.yaml:2: found nothing as a key, expected a word as a key"},
        Mistake{"tab", "name: a\nseed: 1\t# one", "a.yaml:2: found a tab, expected spaces"},
        Mistake{"empty", "", "a.yaml:1: found nothing, expected a block of keys, as in \"name: value\""},
        Mistake{"onlyAComment", "# nothing yet\n",
                "a.yaml:1: found nothing, expected a block of keys, as in \"name: value\""},
        Mistake{"listAsRoot", "- a\n- b",
                "a.yaml:1: found a list, expected a block of keys, as in \"name: value\""},
        Mistake{"wordAsRoot", "\nname:a",
                "a.yaml:2: found name:a, expected a block of keys, as in \"name: value\""},
        Mistake{"endOfTextByte", "seed: 1\nname: a\x04",
                "a.yaml:2: found byte 0x04, expected text without control characters"},
        Mistake{"zeroByte", std::string("seed: 1\n\0", 9),
                "a.yaml:2: found byte 0x00, expected text without control characters"},
        Mistake{"latin1", "name: caf\xe9", "a.yaml:1: found byte 0xe9, expected text in UTF-8"},
        Mistake{"tooLarge", std::string((1 << 20) + 1, '#'),
                "a.yaml: found more than 1 MiB, expected a YAML file of at most 1 MiB"}));

TEST(YamlConfig, RejectsAliasesAndUndefinedOnes) {
  EXPECT_THAT(complaints("low_px: &r 3\nhigh_px: *r"),
              ElementsAre("a.yaml:1: low_px: found an anchor (&), expected the value alone",
                          "a.yaml:2: high_px: found an alias (*), expected the value itself"));
  EXPECT_THAT(complaints("high_px: *r"), ElementsAre(StartsWith("a.yaml:1: column ")));
}

TEST(YamlConfig, SaysLineAndColumnOfBrokenSyntax) {
  EXPECT_THAT(complaints("seed: 1\nradii_px: [1, 2\nname: a\n"),
              ElementsAre(testing::AllOf(StartsWith("a.yaml:3: column "),
                                         HasSubstr("expected YAML that can be parsed"))));
  EXPECT_THAT(complaints("seed: 1\nname: \"a"), ElementsAre(StartsWith("a.yaml:2: column ")));
  EXPECT_THAT(complaints("window:\n\tevents: 5\n"),
              testing::Contains("a.yaml:2: found a tab, expected spaces"));
  EXPECT_THAT(complaints("seed: 1\nseed: 2\nradii_px: ]\n"),
              ElementsAre(StartsWith("a.yaml:2: seed: found the key a second time"),
                          StartsWith("a.yaml:3: column ")));
  EXPECT_EQ(complaints("seed: 1\nb:2\n").size(), 1u);
  EXPECT_EQ(complaints(std::string(100000, '[')).size(), 1u);  // not a stack overflow
}

TEST(YamlConfig, ReportsAllProblemsInTheOrderOfTheFile) {
  EXPECT_THAT(
      complaints("window:\n  events: 0\n  event: 3\nseed: -1\nseed: 2\nradii_px: [0, 5, 101]\nfoo: 1\n",
                 {"seed=-2", "duration_s=0"}, {"name"}),
      ElementsAre(StartsWith("a.yaml:1: name: found no such key, expected text"),
                  StartsWith("a.yaml:2: window.events: found 0,"),
                  StartsWith("a.yaml:3: window.event: found an unknown key"),
                  StartsWith("a.yaml:5: seed: found the key a second time"),
                  StartsWith("a.yaml:6: radii_px[0]: found 0,"),
                  StartsWith("a.yaml:6: radii_px[2]: found 101,"),
                  StartsWith("a.yaml:7: foo: found an unknown key"), StartsWith("--set seed: found -2,"),
                  StartsWith("--set duration_s: found 0,")));
}

TEST(YamlConfig, AFieldWithAProblemDoesNotMakeAConditionFail) {
  EXPECT_THAT(complaints("low_px: 50\nhigh_px: sixty"),
              ElementsAre(StartsWith("a.yaml:2: high_px: found sixty")));
}

TEST(YamlConfig, RequiredKeysAreMissedInBlocksThatAreThereOrNot) {
  const std::vector<std::string> required = {"window", "window.events", "seed"};
  EXPECT_THAT(complaints("name: a", {}, required),
              ElementsAre("a.yaml:1: seed: found no such key, expected a whole number in [0, 9e+18]",
                          "a.yaml:1: window: found no such key, expected a block of keys"));
  EXPECT_THAT(complaints("seed: 1\nwindow: {directed: true}", {}, required),
              ElementsAre(StartsWith("a.yaml:2: window.events: found no such key")));
  EXPECT_THAT(complaints("name: a", {}, {"window.events"}),
              ElementsAre(StartsWith("a.yaml:1: window.events: found no such key")));
  EXPECT_THAT(complaints("name: a", {"seed=1", "window.events=3"}, required), ElementsAre());
}

TEST(SetValue, ReplacesAndAddsValuesOfEveryKind) {
  const Config config = read("name: a\nwindow: {events: 5, directed: false}",
                             {"seed=7", "window.events=6", "clutter=rectilinear", "position_m=[1, 2, 3]",
                              "corners_m=[[1, 2]]", "name=\"x=y\"", "window.directed=true", "seed=8"});
  Config expected;
  expected.name = "x=y";
  expected.seed = 8;
  expected.clutter = "rectilinear";
  expected.position_m = {1, 2, 3};
  expected.corners_m = {{1, 2}};
  expected.window = {6, true};
  EXPECT_EQ(config, expected);
}

TEST(SetValue, SaysWhatIsWrongByItsPath) {
  const auto complaint = [](const std::string& set) { return complaints("seed: 1\nname: a\n", {set}); };
  EXPECT_THAT(complaint("duration_s=010"),
              ElementsAre("--set duration_s: found 010 (leading zero)" + number));
  EXPECT_THAT(complaint("duration_s="), ElementsAre("--set duration_s: found nothing" + number));
  EXPECT_THAT(
      complaint("window.event=3"),
      ElementsAre(StartsWith("--set window.event: found an unknown key, expected a known key; did you")));
  EXPECT_THAT(complaint("windo.events=3"), ElementsAre(StartsWith("--set windo: found an unknown key")));
  EXPECT_THAT(complaint("seed.low=3"),
              ElementsAre("--set seed.low: found 1 at seed, expected a block of keys there"));
  EXPECT_THAT(complaint("seed"), ElementsAre("--set: found \"seed\", expected key.path=value"));
  EXPECT_THAT(complaint("=3"), ElementsAre("--set: found \"=3\", expected key.path=value"));
  EXPECT_THAT(complaint("window..events=3"), ElementsAre(StartsWith("--set: found \"window..events=3\"")));
  EXPECT_THAT(complaint("radii_px=[1, 2"),
              ElementsAre(testing::AllOf(StartsWith("--set radii_px: "), HasSubstr("expected YAML that"))));
  EXPECT_THAT(complaint("window={events: 1, events: 2}"),
              ElementsAre("--set window.events: found the key a second time, expected each key once"));
  EXPECT_THAT(complaint("name=\x04"), ElementsAre(StartsWith("--set name: found byte 0x04")));
  EXPECT_THAT(complaint("position_m=[1, x, 3]"), ElementsAre(StartsWith("--set position_m[1]: found x")));
}

TEST(SetValue, WorksWithoutAFile) {
  YamlTree tree;
  set_value(tree, "window.events=700");
  EXPECT_EQ(read_config<Config>(tree).window.events, 700);
  EXPECT_THROW(static_cast<void>(read_config<Config>(tree, {}, {"name"})), InputError);
}

TEST(YamlFile, ThatIsMissingOrAFolderIsOneLine) {
  const auto complaint = [](const std::filesystem::path& path) {
    try {
      static_cast<void>(read_yaml_file(path));
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(complaint("no/such.yaml"), "no/such.yaml: found no such file, expected a readable YAML file");
  const std::string folder = std::filesystem::temp_directory_path();
  EXPECT_EQ(complaint(folder), folder + ": found a folder, expected a YAML file");
}

TEST(YamlFile, IsNamedInMessagesAsTheUserNamedIt) {
  const std::filesystem::path path =
      std::filesystem::temp_directory_path() / ("saccade_config_" + std::to_string(::getpid()) + ".yaml");
  std::ofstream(path) << "\xef\xbb\xbfname: with byte order mark\r\nseed: x\r\n";
  const YamlTree tree = read_yaml_file(path);
  std::filesystem::remove(path);
  EXPECT_EQ(tree.root.find("name")->text, "with byte order mark");
  try {
    static_cast<void>(read_config<Config>(tree));
    FAIL() << "x is no seed";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), StartsWith(path.string() + ":2: seed: found x,"));
  }
}

/// Any bits that make a finite double.
double finite_double(const RandomStream& random, std::uint64_t stream, std::uint64_t i) {
  const auto value = std::bit_cast<double>(random.bits(stream, i));
  return std::isfinite(value) ? value : 0.0;
}

TEST(YamlWriter, WhatIsWrittenReadsBackIdentical) {
  const RandomStream random(1, "round trip");
  const std::string letters = "a0 :#-'\"\\\n\t\r\x01\x7f[]{},&*!|>%@`~.=?";
  for (std::uint64_t i = 0; i < 500; ++i) {
    Config config;
    config.name.clear();
    for (std::uint64_t n = random.bits(0, i) % 8, k = 0; k < n; ++k) {
      config.name += letters[random.bits(10 + k, i) % letters.size()];
    }
    config.seed = static_cast<std::int64_t>(random.bits(1, i) % 9'000'000'000'000'000'000ULL);
    config.low_px = finite_double(random, 2, i);
    config.high_px = finite_double(random, 3, i);
    if (config.low_px > config.high_px) std::swap(config.low_px, config.high_px);
    config.clutter = i % 2 == 0 ? "textured" : "rectilinear";
    config.position_m[1] = random.uniform(-10.0, 10.0, 4, i);
    config.radii_px.fill(random.uniform(1.0, 100.0, 5, i));
    config.corners_m.assign(i % 3, std::array{finite_double(random, 6, i), finite_double(random, 7, i)});
    config.window.directed = i % 5 == 0;
    for (const auto comments : {YamlWriter::Comments::none, YamlWriter::Comments::all}) {
      const std::string yaml = write_config(config, comments);
      ASSERT_EQ(complaints(yaml), std::vector<std::string>{}) << yaml;
      ASSERT_EQ(read(yaml), config) << yaml;
    }
  }
}

TEST(YamlWriter, QuotesWordsThatMeanSomethingElse) {
  for (const char* word :
       {"true", "null", "no", "~", "", "1e3", "0x1", "-", "- a", "a: b", "on", ".nan", "é"}) {
    Config config;
    config.name = word;
    const std::string yaml = write_config(config);
    EXPECT_THAT(yaml, StartsWith("name: \"")) << word;
    EXPECT_EQ(read(yaml).name, word);
  }
}

TEST(YamlWriter, CommentsMakeTheReferenceOfTheKeys) {
  const std::string yaml = write_config(Config{}, YamlWriter::Comments::all);
  EXPECT_THAT(yaml, HasSubstr("duration_s: 4  # how long it takes; a number in [0.01, 3600]\n"));
  EXPECT_THAT(yaml,
              HasSubstr("window:  # which events count\n  events: 1500  # events in the window; a whole"));
}

/// Reads, and writes and reads again when that went well; anything but InputError escapes and fails.
bool survives(const std::string& bytes) {
  try {
    const Config config = read(bytes);
    EXPECT_EQ(read(write_config(config)), config) << bytes;
    return true;
  } catch (const InputError& error) {
    EXPECT_FALSE(error.problems().empty());
    return false;
  }
}

TEST(YamlFuzz, RandomBytesEndInAnInputErrorOrAConfig) {
  const RandomStream random(2, "bytes");
  const std::string alphabet = " \n:-[]{},#&*!|>'\"%@?0123456789.eabxnul\t\\\xc3\xa9";
  for (std::uint64_t i = 0; i < 4000; ++i) {
    std::string bytes(random.bits(0, i) % 60, ' ');
    for (std::size_t k = 0; k < bytes.size(); ++k) {
      const std::uint64_t r = random.bits(1 + k, i);
      bytes[k] = i % 4 == 0 ? static_cast<char>(r & 0xff) : alphabet[r % alphabet.size()];
    }
    survives(bytes);
    YamlTree tree;
    set_value(tree, bytes);
  }
}

TEST(YamlFuzz, DamagedFilesEndInAnInputErrorOrAConfig) {
  Config config;
  config.corners_m = {{0, 1}, {2, 3}};
  config.name = "a name";
  const std::string whole = write_config(config, YamlWriter::Comments::all);
  const RandomStream random(3, "damage");
  int fine = 0;
  constexpr int trials = 4000;
  for (std::uint64_t i = 0; i < trials; ++i) {
    std::string bytes = whole.substr(0, i % 3 == 0 ? random.bits(0, i) % whole.size() : whole.size());
    for (std::uint64_t k = 0; k < 1 + i % 3 && !bytes.empty(); ++k) {
      bytes[random.bits(1 + k, i) % bytes.size()] = static_cast<char>(random.bits(10 + k, i) & 0x7f);
    }
    fine += survives(bytes) ? 1 : 0;
  }
  EXPECT_GT(fine, trials / 20);  // both outcomes are exercised
  EXPECT_LT(fine, trials - trials / 20);
}

}  // namespace
}  // namespace saccade
