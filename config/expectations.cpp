#include "config/expectations.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "config/figure_path.h"
#include "evaluation/scoring/metrics.h"

namespace saccade {
namespace {

struct Bound {
  std::string_view key;
  std::string_view words;
  std::optional<double> Expectation::*value;
  std::string_view doc;
};

constexpr std::array<Bound, 4> bounds = {{
    {"at_least", "at least", &Expectation::at_least, "the smallest value that passes"},
    {"above", "above", &Expectation::above, "larger values pass"},
    {"at_most", "at most", &Expectation::at_most, "the largest value that passes"},
    {"below", "below", &Expectation::below, "smaller values pass"},
}};

void describe_bounds(FieldVisitor& v, Expectation& e) {
  for (const Bound& bound : bounds) {
    std::optional<double>& value = e.*bound.value;
    if (!v.has_section(bound.key, value.has_value())) continue;
    double number = value.value_or(0.0);
    v.real(bound.key, number, {}, bound.doc);
    value = number;
  }
}

void describe_list(FieldVisitor& v, Expectation& e) {
  std::array<double, 2> range = {e.at_least.value_or(0.0), e.at_most.value_or(0.0)};
  v.reals(e.metric, range, {},
          "smallest and largest value that passes, or a block with at_least or above, at_most or below");
  e.at_least = range[0];
  e.at_most = range[1];
}

}  // namespace

bool Expectation::holds(double value) const {
  return (!at_least || value >= *at_least) && (!above || value > *above) && (!at_most || value <= *at_most) &&
         (!below || value < *below);
}

std::string Expectation::text() const {
  if (listed) return text_of(at_least.value_or(0.0)) + " to " + text_of(at_most.value_or(0.0));
  std::string text;
  for (const Bound& bound : bounds) {
    if (const std::optional<double>& value = this->*bound.value)
      text += (text.empty() ? "" : " and ") + std::string(bound.words) + " " + text_of(*value);
  }
  return text;
}

std::string JudgedExpectation::text() const {
  return expectation.metric + " is " + (value ? text_of(*value) : "null") + ", expected " +
         expectation.text();
}

std::vector<Expectation> expectations_in(const YamlTree& tree) {
  std::vector<Expectation> expectations;
  const YamlNode* block = tree.root.find("expect");
  if (block == nullptr) return expectations;
  for (std::size_t i = 0; i < block->keys.size(); ++i) {
    expectations.push_back({.metric = block->keys[i], .listed = block->items[i].kind != YamlNode::Kind::map});
  }
  return expectations;
}

void describe_expectations(FieldVisitor& v, std::vector<Expectation>& expectations,
                           const std::function<bool(const std::string&)>& is_figure) {
  v.section(
      "expect",
      [&](FieldVisitor& block) {
        std::vector<std::string> named;
        for (const Expectation& e : expectations) named.push_back(e.metric);
        for (const std::string& metric : block.section_keys(named)) {
          if (std::ranges::find(named, metric) == named.end()) expectations.push_back({.metric = metric});
        }
        for (Expectation& e : expectations) {
          if (e.listed) {
            describe_list(block, e);
          } else {
            block.section(
                e.metric, [&](FieldVisitor& w) { describe_bounds(w, e); }, "bounds of a figure");
          }
          const auto highest_low = std::max(e.at_least, e.above);
          const auto lowest_high = e.at_most && e.below ? std::min(e.at_most, e.below)
                                   : e.at_most          ? e.at_most
                                                        : e.below;
          block.require(highest_low || lowest_high, e.metric, "no bound",
                        "at_least, above, at_most or below");
          block.require(!highest_low || !lowest_high || *highest_low <= *lowest_high, e.metric, e.text(),
                        "a lower bound that is not above the upper one");
          block.require(is_figure(e.metric), e.metric, "no such figure",
                        "the path of a number in metrics.json, such as gaze.in_view_ratio");
        }
      },
      "ranges of figures that the run must reach; exit status 3 otherwise");
}

std::vector<JudgedExpectation> judge(const std::vector<Expectation>& expectations, const Metrics& metrics) {
  const nlohmann::json figures = nlohmann::json::parse(metrics_to_json(metrics));
  std::vector<JudgedExpectation> judged;
  for (const Expectation& e : expectations) {
    const nlohmann::json* figure = find_figure(figures, e.metric);
    const bool known = figure != nullptr && figure->is_number();
    judged.push_back({e, known ? std::optional(figure->get<double>()) : std::nullopt});
  }
  return judged;
}

}  // namespace saccade
