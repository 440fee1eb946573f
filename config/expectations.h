#pragma once

#include <optional>
#include <string>
#include <vector>

#include "config/yaml_tree.h"
#include "core/config.h"

namespace saccade {

struct Metrics;

/// A figure of metrics.json and the bounds that it must keep. In a scenario:
///
///     expect:
///       gaze.on_target_ratio: [0.97, 1]             # both bounds pass
///       gaze.acquire_s: {below: 1}                  # one bound, which does not pass itself
///       gaze.wrong_moves: {at_least: 0, at_most: 5}
struct Expectation {
  std::string metric;  ///< its path in metrics.json, e.g. gaze.in_view_ratio
  bool listed = true;  ///< written as a list of two numbers; then at_least and at_most are given
  // None: no such bound.
  std::optional<double> at_least = std::nullopt;
  std::optional<double> above = std::nullopt;
  std::optional<double> at_most = std::nullopt;
  std::optional<double> below = std::nullopt;

  [[nodiscard]] bool holds(double value) const;
  /// "0.97 to 1", "below 1", "above 0 and at most 5".
  [[nodiscard]] std::string text() const;
};

/// The figures that the key `expect` of a scenario file names, with the form of each one's bounds. YamlReader reads the
/// numbers through describe_expectations().
[[nodiscard]] std::vector<Expectation> expectations_in(const YamlTree& tree);

/// The key `expect`. `is_figure`: whether a path is a number in metrics.json of the scenario.
void describe_expectations(FieldVisitor& v, std::vector<Expectation>& expectations,
                           const std::function<bool(const std::string&)>& is_figure);

/// What a run made of one expectation.
struct JudgedExpectation {
  Expectation expectation;
  std::optional<double> value;  ///< none: null in metrics.json, which meets no expectation
  [[nodiscard]] bool met() const { return value && expectation.holds(*value); }
  /// "gaze.acquire_s is 1.2, expected below 1"
  [[nodiscard]] std::string text() const;
};

/// One for each of the expectations, in their order.
[[nodiscard]] std::vector<JudgedExpectation> judge(const std::vector<Expectation>& expectations,
                                                   const Metrics& metrics);

}  // namespace saccade
