#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include "apps/cli/commands.h"
#include "apps/sweep/benchmark_list.h"
#include "apps/sweep/dataset_file.h"
#include "apps/sweep/sweep_config.h"
#include "config/key_reference.h"
#include "config/robot_file.h"
#include "config/scenario.h"
#include "evaluation/scoring/metric_reference.h"
#include "evaluation/sensor_fit/stimulus.h"
#include "recording/table_reference.h"

namespace saccade {
namespace {

/// A part of the reference.
struct Section {
  std::string name;
  std::string about;
  std::vector<KeyRow> rows;
  std::string row = "key";  ///< what a row is
};

NamedDetectors one_detector(const Registry& registry) {
  return {{"NAME", registry.detectors.config(registry.detectors.names().front())}};
}

/// Keys of a detector are listed under detectors.PRESET.
void drop_detector_keys(std::vector<KeyRow>& rows) {
  std::erase_if(rows, [](const KeyRow& row) {
    return row.path.starts_with("detectors.NAME.") && row.path != "detectors.NAME.preset";
  });
}

std::vector<KeyRow> scenario_rows(const Registry& registry) {
  std::vector<KeyRow> rows = list_keys([&](FieldVisitor& v) {
    Scenario scenario = empty_scenario(registry);
    scenario.detectors = one_detector(registry);
    describe(v, scenario);
  });
  drop_detector_keys(rows);
  return rows;
}

std::vector<KeyRow> robot_rows(const Registry& registry) {
  std::vector<KeyRow> rows = list_keys([&](FieldVisitor& v) {
    RobotFile robot = empty_robot_file(registry);
    robot.detectors = one_detector(registry);
    describe(v, robot);
  });
  drop_detector_keys(rows);
  return rows;
}

std::vector<KeyRow> sweep_rows() {
  std::vector<KeyRow> rows = list_keys([](FieldVisitor& v) {
    SweepConfig sweep;
    describe(v, sweep);
  });
  const auto block = [&](const char* path, const char* type, const char* doc) {
    rows.push_back({path, type, "", "", "", "", doc});
  };
  block("set.KEY", "value", "a key of the scenario, for all runs");
  block("axes.KEY", "list, or block", "values of a key of the scenario; the axes are crossed");
  block("axes.KEY.range", "list of 2 numbers", "`steps` values evenly, both ends included");
  block("axes.KEY.log_range", "list of 2 numbers", "`steps` values evenly in the logarithm");
  block("axes.KEY.steps", "whole number", "count of values of range and log_range");
  block("axes.KEY.random", "list of 2 numbers", "one value for each of `samples`, drawn evenly");
  block("axes.KEY.latin_hypercube", "list of 2 numbers", "one value in each of `samples` equal stretches");
  block("axes.KEY.log", "true or false", "of random and latin_hypercube: evenly in the logarithm");
  block("axes.KEY.whole", "true or false", "rounded to whole numbers");
  block("axes.KEY.seeds", "whole number", "so many seeds");
  block("axes.KEY.first", "whole number", "the first of the seeds; by default 1");
  block("axes.NAME.cases.LABEL", "block", "several keys of the scenario and their values at once");
  block("except", "list of blocks", "combinations that are left out");
  block("only", "list of blocks", "combinations that are kept; by default all");
  block("report.metrics", "list", "paths of numbers in metrics.json, the main one first");
  return rows;
}

std::vector<KeyRow> dataset_rows() {
  std::vector<KeyRow> rows = list_keys([](FieldVisitor& v) {
    DatasetFile file;
    describe(v, file);
  });
  rows.push_back({"scenario, set, axes, except, only, samples, sample_seed", "", "", "", "", "",
                  "as of a sweep, for every split"});
  rows.push_back({"splits.NAME", "block", "", "", "", "",
                  "a split: the same keys for it alone; a key of its `set` or `axes` replaces that of all"});
  return rows;
}

/// The first words of paths such as "ball.diameter_m", in their order.
std::vector<std::string> blocks_of(const std::vector<KeyRow>& rows) {
  std::vector<std::string> blocks;
  for (const KeyRow& row : rows) {
    const std::size_t dot = row.path.find('.');
    const std::string block = row.path.substr(0, dot);
    if (dot != std::string::npos && std::find(blocks.begin(), blocks.end(), block) == blocks.end())
      blocks.push_back(block);
  }
  return blocks;
}

/// The rows of a block, without its name.
std::vector<KeyRow> rows_of(const std::vector<KeyRow>& all, const std::string& block) {
  std::vector<KeyRow> rows;
  for (KeyRow row : all) {
    if (!row.path.starts_with(block + ".")) continue;
    row.path.erase(0, block.size() + 1);
    rows.push_back(std::move(row));
  }
  return rows;
}

/// The keys of metrics.json, with the blocks of a detector, of the gaze and of its eye movements apart.
std::vector<Section> metrics_sections() {
  std::vector<Section> sections = {{"metrics", "metrics.json of a run folder", {}},
                                   {"metrics.detectors", "detectors.NAME in metrics.json", {}},
                                   {"metrics.eye_movements", "gaze.eye_movements in metrics.json", {}},
                                   {"metrics.gaze", "gaze in metrics.json", {}}};
  for (const MetricRow& row : metric_reference()) {
    const std::string_view prefix[] = {"", "detectors.NAME.", "gaze.eye_movements.", "gaze."};
    std::size_t i = 1;
    while (i < sections.size() && !row.path.starts_with(prefix[i])) ++i;
    if (i == sections.size()) i = 0;
    const std::string path(row.path.substr(prefix[i].size()));
    sections[i].rows.push_back(
        {path, std::string(row.type), unit_of_key(path), "", "", "", std::string(row.doc)});
  }
  return sections;
}

std::vector<Section> table_sections() {
  std::vector<Section> sections;
  for (const TableReference& table : run_tables()) {
    Section& section = sections.emplace_back(Section{table.file, "table of a run folder", {}, "column"});
    for (const ColumnReference& column : table.columns)
      section.rows.push_back({column.name, column.type, unit_of_key(column.name), "", "", "", column.doc});
  }
  return sections;
}

std::vector<Section> all_sections(const Registry& registry) {
  std::vector<Section> sections;
  const std::vector<KeyRow> scenario = scenario_rows(registry);
  sections.push_back({"scenario", "all keys of a scenario", scenario});
  for (const std::string& block : blocks_of(scenario))
    sections.push_back({block, "block of a scenario", rows_of(scenario, block)});
  for (const std::string& preset : registry.detectors.names()) {
    sections.push_back({"detectors." + preset, "detector, in a scenario, a robot file or a file of detectors",
                        list_keys([&](FieldVisitor& v) {
                          DetectorConfig config = registry.detectors.config(preset);
                          describe(v, config);
                        })});
  }
  const std::vector<KeyRow> robot = robot_rows(registry);
  sections.push_back({"robot", "all keys of a robot file", robot});
  for (const std::string& block : blocks_of(robot))
    sections.push_back({"robot." + block, "block of a robot file", rows_of(robot, block)});
  sections.push_back({"sweep", "keys of a sweep file", sweep_rows()});
  sections.push_back({"benchmark", "keys of a list of saccade benchmark", list_keys([](FieldVisitor& v) {
                        BenchmarkList list;
                        describe(v, list);
                      })});
  sections.push_back({"dataset", "keys of the file of a data set", dataset_rows()});
  sections.push_back({"stimulus", "keys of a stimulus file", list_keys([](FieldVisitor& v) {
                        StimulusFile file;
                        file.stimuli.emplace_back("NAME", Stimulus{});
                        describe(v, file);
                      })});
  std::ranges::move(metrics_sections(), std::back_inserter(sections));
  std::ranges::move(table_sections(), std::back_inserter(sections));
  return sections;
}

std::vector<std::string> names_of(const std::vector<Section>& sections) {
  std::vector<std::string> names;
  names.reserve(sections.size());
  for (const Section& section : sections) names.push_back(section.name);
  return names;
}

constexpr std::size_t text_columns = 100;

struct KeysOptions {
  std::string section;
  bool markdown = false;
};

int print_keys(const KeysOptions& options, const Registry& registry) {
  const std::vector<Section> sections = all_sections(registry);
  if (options.section.empty()) {
    for (const Section& section : sections)
      fmt::print("{:<28}{}, {} {}s\n", section.name, section.about, section.rows.size(), section.row);
    return 0;
  }
  for (const Section& section : sections) {
    if (section.name != options.section) continue;
    fmt::print("{}", options.markdown ? keys_as_markdown(section.rows, section.row)
                                      : keys_as_text(section.rows, text_columns));
    return 0;
  }
  throw InputError("saccade keys", options.section, expectation_of(names_of(sections)));
}

}  // namespace

void add_keys_command(CommandLine& line, const Registry& registry) {
  auto options = std::make_shared<KeysOptions>();
  Command command =
      line.add_command("keys",
                       "The reference of every key of scenarios, robot files, sweeps, stimulus "
                       "files, detectors and the emulator, of metrics.json, and of the columns of a "
                       "run's tables");
  command.option("section", options->section, "One section; without it the list of all sections")
      .offers([&registry] { return names_of(all_sections(registry)); });
  command.flag("--markdown", options->markdown, "As a Markdown table");
  std::string presets;
  for (const std::string& preset : registry.detectors.names()) presets += " detectors." + preset;
  command.footer(
      "Sections: scenario and its blocks (run lab ball objects board plant camera right_camera calibration "
      "right_calibration render emulator detectors frame_30hz gaze latency output expect);" +
      presets +
      "; robot and its blocks (robot.yarp ...); sweep; benchmark; dataset; stimulus; metrics, "
      "metrics.detectors, "
      "metrics.gaze, metrics.eye_movements; truth.csv and the other tables of a run folder.");
  command.action([options, &registry] { return print_keys(*options, registry); });
}

}  // namespace saccade
