#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "config/yaml_tree.h"
#include "core/config.h"

namespace saccade {

/// A value for a key of the scenario.
struct SweepSetting {
  std::string key;    ///< its path, such as ball.diameter_m
  YamlNode value;     ///< null: the key is taken out
  std::string place;  ///< where it was written, for messages
};

/// One point of an axis.
struct SweepValue {
  std::string text;  ///< in tables: a number, a word, [1, 2] ...
  std::vector<SweepSetting> settings;
};

/// A key or a group of keys that is varied. Axes are crossed with one another; those that are `sampled` take their i-th value
/// together.
struct SweepAxis {
  std::string key;  ///< of the scenario, or the name of its `cases`
  std::string place;
  bool sampled = false;
  std::vector<SweepValue> values;
};

/// A rule matches a combination if all of its conditions do.
struct SweepCondition {
  std::size_t axis = 0;
  std::string relation;  ///< one_of, not, below, above, at_least, at_most
  std::vector<std::string> operands;
  std::optional<std::size_t> other;  ///< an axis to compare with instead of operands
};
using SweepRule = std::vector<SweepCondition>;

/// Which values of a sweep's main metric are the worst.
enum class WorstValue { lowest, highest };
constexpr auto words_of(WorstValue) {
  return std::to_array<Word<WorstValue>>({{WorstValue::lowest, "lowest"}, {WorstValue::highest, "highest"}});
}

/// Many runs of one scenario, as a sweep file describes them.
///
///     name: ball_speed
///     scenario: ../hand_move.yaml           # relative to this file
///     set: {run.duration_s: 2}              # for all runs
///     axes:
///       ball.trajectory.frequency_hz: {log_range: [0.5, 4], steps: 4}
///       lab.clutter: [textured, rectilinear]
///       seed: {seeds: 3}
///     except: [{lab.clutter: rectilinear, ball.trajectory.frequency_hz: {above: 2}}]
///     report: {metrics: [detectors.best.recall], worst: 3}
struct SweepConfig {
  std::string name;
  std::string description;
  std::filesystem::path scenario;
  std::vector<SweepSetting> set;
  std::vector<SweepAxis> axes;  ///< the first one turns slowest
  std::int64_t samples = 0;     ///< of the sampled axes
  std::int64_t sample_seed = 1;
  std::vector<SweepRule> except;  ///< combinations of which any holds are left out
  std::vector<SweepRule> only;    ///< if there are any: combinations of which none holds are left out

  struct Report {
    /// Paths of numbers in metrics.json, the main one first.
    std::vector<SweepSetting> metrics;
    std::int64_t worst = 3;  ///< so many of the worst runs are run once more, with a report of their own
    WorstValue worst_is = WorstValue::lowest;
  } report;
};

/// Keys of a sweep file with a value of their own: all but set, axes, except, only and report.metrics.
void describe(FieldVisitor& v, SweepConfig& config);

/// Reads a sweep file; `assignments` are the `key=value` of --set, which replace the values of `set` for their keys.
/// The scenario is not read. Throws InputError with everything that is wrong.
[[nodiscard]] SweepConfig read_sweep(const std::filesystem::path& path,
                                     const std::vector<std::string>& assignments);
/// The same of a tree whose file lies in `folder`.
[[nodiscard]] SweepConfig read_sweep(YamlTree tree, const std::filesystem::path& folder,
                                     const std::vector<std::string>& assignments);

/// The value as a number, where the whole text is one.
[[nodiscard]] std::optional<double> number_in(const std::string& text);

}  // namespace saccade
