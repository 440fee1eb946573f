#include "apps/sweep/sweep_config.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numeric>
#include <set>

#include "config/scenario.h"
#include "config/sections.h"
#include "config/yaml_reader.h"
#include "core/random.h"

namespace saccade {
namespace {

using Kind = YamlNode::Kind;

constexpr std::array<std::string_view, 5> drawn_kinds = {"range", "log_range", "random", "latin_hypercube",
                                                         "seeds"};
constexpr std::string_view axis_expectation =
    "a list of values, or a block with one of range, log_range, random, latin_hypercube, seeds, cases";
constexpr double most_values = 1e5;

/// The keys of an axis whose values are computed.
struct DrawnAxis {
  std::string kind;
  std::array<double, 2> range = {0.0, 1.0};
  std::int64_t count = 0;  ///< steps or seeds
  std::int64_t first = 1;
  bool log = false;
  bool whole = false;
};

bool is_sampled(const DrawnAxis& axis) { return axis.kind == "random" || axis.kind == "latin_hypercube"; }

void describe(FieldVisitor& v, DrawnAxis& axis) {
  if (axis.kind == "seeds") {
    v.integer("seeds", axis.count, {1, most_values}, "how many");
    v.integer("first", axis.first, {0, 9e15}, "the first of them");
    return;
  }
  v.reals(axis.kind, axis.range, {}, "smallest and largest value");
  const bool needs_steps = !is_sampled(axis);
  if (needs_steps) v.integer("steps", axis.count, {2, most_values}, "how many values, both ends included");
  if (!needs_steps) v.boolean("log", axis.log, "evenly in the logarithm");
  v.boolean("whole", axis.whole, "rounded to whole numbers");
  v.require(axis.range[0] < axis.range[1], axis.kind, text_of(axis.range[0]), "the smaller value first");
  v.require(axis.range[0] > 0.0 || !(axis.log || axis.kind == "log_range"), axis.kind, text_of(axis.range[0]),
            "values above 0, for a logarithm");
}

/// The value at a share (0 to 1) of the range, with at most 12 digits.
double value_at(const DrawnAxis& axis, double share) {
  const double low = axis.range[0];
  const double high = axis.range[1];
  const bool log = axis.log || axis.kind == "log_range";
  double value = log ? low * std::pow(high / low, share) : low + (high - low) * share;
  if (axis.whole) value = std::round(value);
  return std::stod(fmt::format("{:.12g}", value));
}

/// The interval of a Latin hypercube's axis that contains sample `i` of `count`: a permutation by sorting random numbers.
std::vector<std::size_t> strata(const RandomStream& random, std::size_t count) {
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return std::pair(random.bits(a, 1), a) < std::pair(random.bits(b, 1), b);
  });
  return order;
}

std::vector<double> values_of(const DrawnAxis& axis, const std::string& key, std::int64_t samples,
                              std::int64_t sample_seed) {
  std::vector<double> values;
  if (is_sampled(axis)) {
    const RandomStream random(static_cast<std::uint64_t>(sample_seed), "sweep " + key);
    const auto count = static_cast<std::size_t>(samples);
    const std::vector<std::size_t> stratum = strata(random, count);
    for (std::size_t i = 0; i < count; ++i) {
      const double u = random.uniform(i);
      const bool hypercube = axis.kind == "latin_hypercube";
      values.push_back(
          value_at(axis, hypercube ? (static_cast<double>(stratum[i]) + u) / static_cast<double>(count) : u));
    }
    return values;
  }
  for (std::int64_t i = 0; i < axis.count; ++i) {
    values.push_back(axis.kind == "seeds"
                         ? static_cast<double>(axis.first + i)
                         : value_at(axis, static_cast<double>(i) / static_cast<double>(axis.count - 1)));
  }
  values.erase(std::unique(values.begin(), values.end()), values.end());  // whole numbers may coincide
  return values;
}

/// A number in YAML, without an exponent for whole numbers.
std::string number_text(double value) {
  return std::abs(value) < 1e15 && value == std::floor(value) ? fmt::format("{:.0f}", value) : text_of(value);
}

std::string table_text(const YamlNode& node) {
  return node.kind == Kind::scalar ? node.text : node.one_line();
}

bool overlap(const std::string& a, const std::string& b) {
  return a == b || a.starts_with(b + ".") || b.starts_with(a + ".");
}

class SweepReader {
 public:
  SweepReader(YamlTree tree, std::filesystem::path folder, const std::vector<std::string>& assignments)
      : tree_(std::move(tree)), folder_(std::move(folder)) {
    const YamlNode set = take("set");
    const YamlNode axes = take("axes");
    const YamlNode except = take("except");
    const YamlNode only = take("only");
    const YamlNode metrics = take("report", "metrics");
    YamlReader reader(tree_, {"name", "scenario"});
    describe(reader, config_);
    config_.scenario = scenario_file(folder_, config_.scenario);
    read_set(set, assignments);
    read_axes(axes);
    check_keys();
    read_rules("except", except, config_.except);
    read_rules("only", only, config_.only);
    read_metrics(metrics);
    finish(reader);
  }

  [[nodiscard]] SweepConfig result() && { return std::move(config_); }

 private:
  /// Removes a value that YamlReader does not read from the tree.
  YamlNode take(const std::string& block, const std::string& key = {}) {
    YamlNode* map = &tree_.root;
    if (!key.empty()) {
      const auto at = std::find(map->keys.begin(), map->keys.end(), block) - map->keys.begin();
      if (at == std::ssize(map->keys)) return {};
      map = &map->items[static_cast<std::size_t>(at)];
    }
    const auto at = std::find(map->keys.begin(), map->keys.end(), key.empty() ? block : key);
    if (at == map->keys.end()) return {};
    const auto item = map->items.begin() + (at - map->keys.begin());
    YamlNode node = std::move(*item);
    map->items.erase(item);
    map->keys.erase(at);
    return node;
  }

  void complain(TextMark mark, std::string_view path, std::string value, std::string_view expectation) {
    problems_.push_back({mark, {tree_.place(mark, path), std::move(value), std::string(expectation)}});
  }

  void read_set(const YamlNode& set, const std::vector<std::string>& assignments) {
    if (set.kind != Kind::nothing && set.kind != Kind::map) {
      complain(set.mark, "set", set.found(), "a block of keys");
    }
    for (std::size_t i = 0; i < set.keys.size(); ++i) {
      config_.set.push_back(
          {set.keys[i], set.items[i], tree_.place(set.items[i].mark, "set." + set.keys[i])});
    }
    for (const std::string& assignment : assignments) {
      YamlTree tree;
      set_value(tree, "value=" + assignment.substr(std::min(assignment.find('=') + 1, assignment.size())));
      const std::string key = assignment.substr(0, assignment.find('='));
      if (key.size() == assignment.size() || key.empty() || !tree.problems.empty()) {
        complain({}, "", quote_yaml(assignment), "key.path=value");
        continue;
      }
      std::erase_if(config_.set, [&](const SweepSetting& s) { return s.key == key; });
      config_.set.push_back({key, *tree.root.entry("value"), "--set " + key});
    }
  }

  void read_axes(const YamlNode& axes) {
    if (axes.kind != Kind::map || axes.keys.empty()) {
      const TextMark mark{std::max(axes.mark.line, 1), axes.mark.column};
      complain(mark, "axes", axes.kind == Kind::map ? "no axis" : axes.found(),
               "a block with an axis or more");
      return;
    }
    for (std::size_t i = 0; i < axes.keys.size(); ++i) {
      const YamlNode& node = axes.items[i];
      SweepAxis axis;
      axis.key = axes.keys[i];
      const std::string path = "axes." + axis.key;
      axis.place = tree_.place(node.mark, path);
      if (node.kind == Kind::list) {
        for (const YamlNode& item : node.items)
          axis.values.push_back({table_text(item), {{axis.key, item, axis.place}}});
        if (node.items.empty()) complain(node.mark, path, "an empty list", "a value or more");
      } else if (node.kind == Kind::map && node.entry("cases") != nullptr) {
        read_cases(node, path, axis);
      } else {
        read_drawn(node, path, axis);
      }
      std::set<std::string> seen;
      for (const SweepValue& value : axis.values) {
        if (!axis.sampled && !seen.insert(value.text).second) {
          complain(node.mark, path, value.text + " twice", "each value once");
        }
      }
      config_.axes.push_back(std::move(axis));
    }
  }

  void read_cases(const YamlNode& node, const std::string& path, SweepAxis& axis) {
    const YamlNode& cases = *node.entry("cases");
    if (node.keys.size() > 1) complain(node.mark, path, "other keys beside cases", "cases alone");
    if (cases.kind != Kind::map || cases.keys.empty()) {
      complain(cases.mark, path + ".cases", cases.kind == Kind::map ? "no case" : cases.found(),
               "a block that has, for each label, the keys of the scenario and their values");
      return;
    }
    for (std::size_t i = 0; i < cases.keys.size(); ++i) {
      const YamlNode& values = cases.items[i];
      const std::string at = path + ".cases." + cases.keys[i];
      if (values.kind != Kind::map) complain(values.mark, at, values.found(), "a block of keys");
      SweepValue value{cases.keys[i], {}};
      for (std::size_t k = 0; k < values.keys.size(); ++k) {
        value.settings.push_back(
            {values.keys[k], values.items[k], tree_.place(values.items[k].mark, at + "." + values.keys[k])});
      }
      axis.values.push_back(std::move(value));
    }
  }

  void read_drawn(const YamlNode& node, const std::string& path, SweepAxis& axis) {
    DrawnAxis drawn;
    for (const std::string_view kind : drawn_kinds) {
      if (node.kind != Kind::map || node.entry(kind) == nullptr) continue;
      if (!drawn.kind.empty()) {
        complain(node.mark, path, drawn.kind + " and " + std::string(kind), "one of them");
        return;
      }
      drawn.kind = kind;
    }
    if (drawn.kind.empty()) {
      complain(node.mark, path, node.found(), axis_expectation);
      return;
    }
    YamlTree block;
    block.file = tree_.file;
    block.root.mark = node.mark;
    block.root.keys = {path};
    block.root.items = {node};
    std::vector<std::string> required;
    if (drawn.kind.ends_with("range")) required.push_back(path + ".steps");
    YamlReader reader(block, std::move(required));
    reader.section(
        path, [&](FieldVisitor& v) { describe(v, drawn); }, "an axis");
    const std::size_t before = problems_.size();
    collect(reader, node.mark);
    axis.sampled = is_sampled(drawn);
    if (axis.sampled && config_.samples == 0) {
      complain(node.mark, path, drawn.kind + " without the key samples",
               "samples, the number of points, at the file's top");
    }
    if (problems_.size() > before) return;
    for (const double number : values_of(drawn, axis.key, config_.samples, config_.sample_seed)) {
      YamlNode value = YamlNode::of(Kind::scalar, node.mark);
      value.text = number_text(number);
      axis.values.push_back({value.text, {{axis.key, value, axis.place}}});
    }
  }

  /// Reports keys that two axes, or an axis and `set`, change.
  void check_keys() {
    const auto keys_of = [](const SweepAxis& axis) {
      std::set<std::string> keys;
      for (const SweepValue& value : axis.values)
        for (const SweepSetting& setting : value.settings) keys.insert(setting.key);
      return keys;
    };
    const auto add = [this](const std::string& place, const std::string& value,
                            const std::string& expectation) {
      problems_.push_back({{1, 0}, {place, value, expectation}});
    };
    std::vector<std::pair<std::string, std::string>> taken;  // key, axis
    for (const SweepAxis& axis : config_.axes) {
      for (const std::string& key : keys_of(axis)) {
        for (const auto& [other, of] : taken) {
          if (of != axis.key && overlap(key, other)) {
            add(axis.place, fmt::format("the key {}, which the axis {} sets too", key, of),
                "one axis for a key");
          }
        }
        for (const SweepSetting& fixed : config_.set) {
          if (fixed.key == key || fixed.key.starts_with(key + ".")) {
            add(fixed.place, "a key that the axis " + axis.key + " sets too", "either of them");
          }
        }
        taken.emplace_back(key, axis.key);
      }
    }
  }

  void read_rules(const std::string& name, const YamlNode& node, std::vector<SweepRule>& rules) {
    if (node.kind == Kind::nothing) return;
    if (node.kind != Kind::list) {
      complain(node.mark, name, node.found(), "a list of blocks, each with axes and values");
      return;
    }
    for (std::size_t i = 0; i < node.items.size(); ++i) {
      const YamlNode& item = node.items[i];
      const std::string path = name + "[" + std::to_string(i) + "]";
      if (item.kind != Kind::map || item.keys.empty()) {
        complain(item.mark, path, item.found(), "a block with axes and values");
        continue;
      }
      SweepRule rule;
      for (std::size_t k = 0; k < item.keys.size(); ++k)
        read_condition(path + "." + item.keys[k], item.keys[k], item.items[k], rule);
      rules.push_back(std::move(rule));
    }
  }

  [[nodiscard]] std::optional<std::size_t> axis_of(const std::string& key) const {
    for (std::size_t i = 0; i < config_.axes.size(); ++i)
      if (config_.axes[i].key == key) return i;
    return std::nullopt;
  }

  void read_condition(const std::string& path, const std::string& key, const YamlNode& node,
                      SweepRule& rule) {
    const std::optional<std::size_t> axis = axis_of(key);
    if (!axis) {
      std::vector<std::string> keys;
      for (const SweepAxis& a : config_.axes) keys.push_back(a.key);
      complain(node.mark, path, "no such axis", expectation_of(keys));
      return;
    }
    if (node.kind != Kind::map) {
      SweepCondition condition{*axis, "one_of", {}, {}};
      if (node.kind == Kind::list) {
        for (const YamlNode& value : node.items) condition.operands.push_back(table_text(value));
      } else {
        condition.operands.push_back(table_text(node));
      }
      rule.push_back(std::move(condition));
      return;
    }
    static const std::vector<std::string> relations = {"not", "below", "above", "at_least", "at_most"};
    for (std::size_t i = 0; i < node.keys.size(); ++i) {
      const YamlNode& value = node.items[i];
      const std::string operand = table_text(value);
      if (std::find(relations.begin(), relations.end(), node.keys[i]) == relations.end()) {
        complain(value.mark, path, node.keys[i], expectation_of(relations));
        continue;
      }
      const std::optional<std::size_t> other = axis_of(operand);
      if (node.keys[i] != "not" && !other && !number_in(operand)) {
        complain(value.mark, path + "." + node.keys[i], value.found(), "a number, or the name of an axis");
      }
      rule.push_back({*axis, node.keys[i], {operand}, other});
    }
  }

  void read_metrics(const YamlNode& node) {
    if (node.kind == Kind::nothing) return;
    if (node.kind != Kind::list || node.items.empty()) {
      complain(node.mark, "report.metrics", node.found(), "a list of paths of numbers in metrics.json");
    }
    for (std::size_t i = 0; i < node.items.size(); ++i) {
      config_.report.metrics.push_back({node.items[i].text, node.items[i],
                                        tree_.place(node.mark, "report.metrics[" + std::to_string(i) + "]")});
    }
  }

  /// Adds the problems of a reader to those found here.
  void collect(YamlReader& reader, TextMark mark) {
    try {
      reader.finish();
    } catch (const InputError& error) {
      for (const Problem& problem : error.problems()) problems_.push_back({mark, problem});
    }
  }

  void finish(YamlReader& reader) {
    collect(reader, {1, 0});
    throw_if_any(std::move(problems_));
  }

  YamlTree tree_;
  std::filesystem::path folder_;
  SweepConfig config_;
  std::vector<MarkedProblem> problems_;
};

}  // namespace

void describe(FieldVisitor& v, SweepConfig& config) {
  describe_name(v, config.name, "name of the sweep, in its report and of its folder");
  v.text("description", config.description, "the question of the sweep, in a sentence");
  std::string scenario = config.scenario.string();
  v.text("scenario", scenario, "scenario file, relative to this file; or the name of one that saccade ships");
  config.scenario = scenario;
  v.integer("samples", config.samples, {1, most_values},
            "number of points of random and latin_hypercube axes");
  v.integer("sample_seed", config.sample_seed, {0, 9e15}, "seed of these points");
  v.section(
      "report",
      [&](FieldVisitor& w) {
        w.integer("worst", config.report.worst, {0, 100}, "number of worst runs that get a report");
        w.choice("worst_is", config.report.worst_is, "whether low or high values of the main metric are bad");
      },
      "the report");
}

SweepConfig read_sweep(const std::filesystem::path& path, const std::vector<std::string>& assignments) {
  return read_sweep(read_yaml_file(path), path.parent_path(), assignments);
}

SweepConfig read_sweep(YamlTree tree, const std::filesystem::path& folder,
                       const std::vector<std::string>& assignments) {
  return SweepReader(std::move(tree), folder, assignments).result();
}

std::optional<double> number_in(const std::string& text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

}  // namespace saccade
