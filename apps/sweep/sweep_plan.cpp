#include "apps/sweep/sweep_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <set>

#include "config/input_files.h"
#include "config/scenario.h"
#include "core/error.h"

namespace saccade {
namespace {

constexpr double most_runs = 1e5;
constexpr std::size_t most_problems = 20;

bool holds(const SweepCondition& condition, const SweepConfig& config,
           const std::vector<std::size_t>& values) {
  const auto text_at = [&](std::size_t axis) -> const std::string& {
    return config.axes[axis].values[values[axis]].text;
  };
  const std::string& value = text_at(condition.axis);
  const auto equals = [&](const std::string& operand) {
    const std::optional<double> a = number_in(value);
    const std::optional<double> b = number_in(operand);
    return a && b ? *a == *b : value == operand;
  };
  if (condition.relation == "one_of") {
    return std::any_of(condition.operands.begin(), condition.operands.end(), equals);
  }
  const std::string& operand = condition.other ? text_at(*condition.other) : condition.operands.front();
  if (condition.relation == "not") return !equals(operand);
  const std::optional<double> a = number_in(value);
  const std::optional<double> b = number_in(operand);
  if (!a || !b) return false;
  if (condition.relation == "below") return *a < *b;
  if (condition.relation == "above") return *a > *b;
  if (condition.relation == "at_least") return *a >= *b;
  return *a <= *b;
}

bool any_holds(const std::vector<SweepRule>& rules, const SweepConfig& config,
               const std::vector<std::size_t>& values) {
  return std::any_of(rules.begin(), rules.end(), [&](const SweepRule& rule) {
    return std::all_of(rule.begin(), rule.end(),
                       [&](const SweepCondition& c) { return holds(c, config, values); });
  });
}

/// The axes that change together, and the number of their values.
struct Wheel {
  std::vector<std::size_t> axes;
  std::size_t size = 0;
};

std::vector<Wheel> wheels_of(const SweepConfig& config) {
  std::vector<Wheel> wheels;
  std::optional<std::size_t> sampled;
  for (std::size_t i = 0; i < config.axes.size(); ++i) {
    const SweepAxis& axis = config.axes[i];
    if (axis.sampled && sampled) {
      wheels[*sampled].axes.push_back(i);
      continue;
    }
    if (axis.sampled) sampled = wheels.size();
    wheels.push_back({{i}, axis.values.size()});
  }
  return wheels;
}

/// Every combination that the rules keep.
std::vector<std::vector<std::size_t>> combinations(const SweepConfig& config) {
  const std::vector<Wheel> wheels = wheels_of(config);
  double count = 1.0;
  for (const Wheel& wheel : wheels) count *= static_cast<double>(wheel.size);
  if (count > most_runs) {
    throw InputError("axes", fmt::format("{:.0f} combinations", count),
                     fmt::format("at most {:.0f}", most_runs));
  }
  std::vector<std::vector<std::size_t>> all;
  for (std::size_t n = 0; n < static_cast<std::size_t>(count); ++n) {
    std::vector<std::size_t> values(config.axes.size());
    std::size_t rest = n;
    for (auto wheel = wheels.rbegin(); wheel != wheels.rend(); ++wheel) {
      for (const std::size_t axis : wheel->axes) values[axis] = rest % wheel->size;
      rest /= wheel->size;
    }
    if (any_holds(config.except, config, values)) continue;
    if (!config.only.empty() && !any_holds(config.only, config, values)) continue;
    all.push_back(std::move(values));
  }
  if (all.empty()) throw InputError("except, only", "no combination left", "one or more");
  return all;
}

/// The values that keep runs short unless the sweep sets them, and those that only a single run has.
std::vector<SweepSetting> quiet_settings() {
  std::vector<SweepSetting> settings;
  const auto add = [&](const char* key, YamlNode::Kind kind, const char* text) {
    YamlNode node = YamlNode::of(kind);
    node.text = text;
    settings.push_back({key, node, "the sweep's own setting"});
  };
  add("run.threads", YamlNode::Kind::scalar, "1");
  add("output.pictures", YamlNode::Kind::scalar, "0");
  add("output.video", YamlNode::Kind::scalar, "false");
  add("expect", YamlNode::Kind::map, "");
  return settings;
}

void lay_over(YamlTree& tree, const SweepSetting& setting) {
  if (setting.value.kind == YamlNode::Kind::nothing) {
    remove_node(tree, setting.key);
  } else {
    set_node(tree, setting.key, setting.value);
  }
}

/// Reads the scenarios of a sweep's combinations, and reports problems at the place in the sweep file that causes them.
class Resolver {
 public:
  Resolver(const SweepConfig& config, const Registry& registry)
      : config_(config),
        registry_(registry),
        base_(read_yaml_file(config.scenario)),
        folder_(config.scenario.parent_path()) {
    for (const SweepSetting& setting : quiet_settings()) lay_over(base_, setting);
    for (const SweepSetting& setting : config.set) lay_over(base_, setting);
  }

  /// None if it has a problem.
  std::optional<Scenario> resolve(const std::vector<std::size_t>& values) {
    YamlTree tree = base_;
    std::vector<const SweepSetting*> settings;
    for (const SweepSetting& setting : config_.set) settings.push_back(&setting);
    for (std::size_t i = 0; i < values.size(); ++i) {
      for (const SweepSetting& setting : config_.axes[i].values[values[i]].settings) {
        lay_over(tree, setting);
        settings.push_back(&setting);
      }
    }
    try {
      return read_scenario(std::move(tree), folder_, registry_);
    } catch (const InputError& error) {
      for (Problem problem : error.problems()) {
        problem.place = place_of(problem.place, settings);
        if (texts_.insert(problem.text()).second) problems_.push_back(std::move(problem));
      }
      return std::nullopt;
    }
  }

  void add_problem(Problem problem) { problems_.push_back(std::move(problem)); }
  void throw_if_any() {
    if (problems_.empty()) return;
    if (problems_.size() > most_problems) {
      const std::size_t more = problems_.size() - most_problems;
      problems_.resize(most_problems);
      problems_.push_back({"the sweep", fmt::format("{} more problems", more), "none"});
    }
    throw InputError(problems_);
  }

 private:
  /// The place in the sweep file that sets the `--set key.path` of a problem.
  static std::string place_of(const std::string& place, const std::vector<const SweepSetting*>& settings) {
    constexpr std::string_view prefix = "--set ";
    if (!place.starts_with(prefix)) return place;
    const std::string path = place.substr(prefix.size());
    const SweepSetting* best = nullptr;
    for (const SweepSetting* setting : settings) {
      const std::string& key = setting->key;
      const bool speaks_of_it = path == key || path.starts_with(key + ".") || path.starts_with(key + "[") ||
                                key.starts_with(path + ".");
      if (speaks_of_it && (best == nullptr || key.size() > best->key.size())) best = setting;
    }
    if (best == nullptr || best->place.starts_with(prefix)) return place;
    return best->place + (path == best->key ? "" : " (" + path + ")");
  }

  const SweepConfig& config_;
  const Registry& registry_;
  YamlTree base_;
  std::filesystem::path folder_;
  std::set<std::string> texts_;
  std::vector<Problem> problems_;
};

/// Control characters would end the comment.
std::string line_of(const FileDigest& file) {
  std::string line = "# reads " + file.key + " " + file.digest + " " + file.path;
  std::ranges::replace_if(
      line, [](char c) { return c >= 0 && c < ' '; }, '?');
  return line + "\n";
}

/// The metrics of the report if the sweep names none.
void add_usual_metrics(const Scenario& scenario, std::vector<std::string>& metrics) {
  const auto add = [&](const std::string& path) {
    if (std::find(metrics.begin(), metrics.end(), path) == metrics.end()) metrics.push_back(path);
  };
  for (const auto& [name, config] : scenario.detectors) add("detectors." + name + ".average_precision");
  if (scenario.gaze.detector == "none") return;
  add("gaze.on_target_ratio");
  add("gaze.fixation_error_deg.median");
}

}  // namespace

std::string files_text(const std::vector<FileDigest>& files) {
  std::string text;
  for (const FileDigest& file : files) text += line_of(file);
  return text;
}

std::vector<std::string> changed_files(const std::vector<FileDigest>& files, const std::string& scenario) {
  std::vector<std::string> changed;
  for (const FileDigest& file : files) {
    if (!file.mentioned && scenario.find(line_of(file)) == std::string::npos) changed.push_back(file.path);
  }
  return changed;
}

SweepPlan plan_sweep(SweepConfig config, std::string version, const Registry& registry) {
  SweepPlan plan;
  Resolver resolver(config, registry);
  InputFiles files;
  std::vector<SweepSetting> unknown = config.report.metrics;
  for (std::vector<std::size_t>& values : combinations(config)) {
    const std::optional<Scenario> scenario = resolver.resolve(values);
    if (!scenario) continue;
    std::erase_if(unknown, [&](const SweepSetting& metric) { return has_figure(*scenario, metric.key); });
    if (config.report.metrics.empty()) add_usual_metrics(*scenario, plan.metrics);
    std::string text = resolved_scenario(*scenario) + files_text(files.of(*scenario));
    std::string id = digest(version + "\n" + text);
    plan.runs.push_back({std::move(id), std::move(values), scenario->seed, std::move(text)});
  }
  resolver.throw_if_any();
  for (const SweepSetting& metric : unknown) {
    resolver.add_problem({metric.place, metric.value.found(),
                          "the path of a number in metrics.json, such as gaze.on_target_ratio"});
  }
  resolver.throw_if_any();
  for (const SweepSetting& metric : config.report.metrics) plan.metrics.push_back(metric.key);
  plan.version = std::move(version);
  plan.config = std::move(config);
  return plan;
}

}  // namespace saccade
