#include "apps/sweep/run_comparison.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/error.h"
#include "recording/number_text.h"

namespace saccade {
namespace {

constexpr double significance = 0.01;

/// Whether `pattern`, in which * stands for any characters, is the whole text.
bool matches(std::string_view pattern, std::string_view text) {
  const std::size_t star = pattern.find('*');
  if (star == std::string_view::npos) return pattern == text;
  if (!text.starts_with(pattern.substr(0, star))) return false;
  const std::string_view rest = pattern.substr(star + 1);
  for (std::size_t i = star; i <= text.size(); ++i) {
    if (matches(rest, text.substr(i))) return true;
  }
  return false;
}

double tolerance_for(const std::string& figure, const MeanSd& a, const std::vector<Tolerance>& tolerances) {
  const auto fits = [&](const Tolerance& t) { return matches(t.key, figure); };
  const auto last = std::find_if(tolerances.rbegin(), tolerances.rend(), fits);
  if (last == tolerances.rend()) return 0.0;
  return last->relative ? last->value * std::abs(a.mean.value_or(0.0)) : last->value;
}

using Figures = std::vector<std::optional<double>>;

/// For each run of B, the place of A's run of the same seed; empty where the seeds are not the same.
std::vector<std::size_t> pairs_of(const SeedRuns& a, const SeedRuns& b) {
  if (a.seeds.size() != b.seeds.size()) return {};
  std::vector<std::size_t> pairs;
  for (const std::string& seed : b.seeds) {
    const auto same = std::ranges::find(a.seeds, seed);
    if (same == a.seeds.end()) return {};
    pairs.push_back(static_cast<std::size_t>(same - a.seeds.begin()));
  }
  return pairs;
}

/// B minus A by seed; none where a run has no value.
std::optional<Figures> differences_of(const Figures& a, const Figures& b,
                                      const std::vector<std::size_t>& pairs) {
  Figures differences;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (!a[pairs[i]] || !b[i]) return std::nullopt;
    differences.emplace_back(*b[i] - *a[pairs[i]]);
  }
  return differences;
}

ComparedFigure compared(const std::string& name, const SeedRuns& a, const SeedRuns& b,
                        const std::vector<std::size_t>& pairs, const std::vector<Tolerance>& tolerances) {
  const auto values_of = [&](const SeedRuns& runs) {
    const auto values = runs.figures.find(name);
    return values == runs.figures.end() ? Figures(runs.seeds.size()) : values->second;
  };
  const Figures in_a = values_of(a);
  const Figures in_b = values_of(b);
  ComparedFigure figure{.name = name, .a = mean_sd_of(in_a), .b = mean_sd_of(in_b), .p_value = std::nullopt};
  figure.tolerance = tolerance_for(name, figure.a, tolerances);
  const auto differences = differences_of(in_a, in_b, pairs);
  figure.p_value = !pairs.empty() && differences ? paired_p_value(mean_sd_of(*differences))
                                                 : welch_p_value(figure.a, figure.b);
  if (!figure.a.mean || !figure.b.mean) {
    figure.changed = figure.a.mean.has_value() != figure.b.mean.has_value();
  } else {
    figure.changed = std::abs(*figure.b.mean - *figure.a.mean) > figure.tolerance &&
                     figure.p_value.value_or(0.0) < significance;
  }
  return figure;
}

ComparedSet compared(const SeedRuns& a, const SeedRuns& b, const std::vector<Tolerance>& tolerances,
                     bool paired) {
  const std::vector<std::size_t> pairs = paired ? pairs_of(a, b) : std::vector<std::size_t>();
  ComparedSet set{.label = a.label == b.label ? a.label : a.label + " | " + b.label,
                  .seeds_a = a.seeds,
                  .seeds_b = b.seeds,
                  .paired = !pairs.empty(),
                  .configuration = difference_text(a.keys, b.keys),
                  .figures = {}};
  std::set<std::string> names;
  for (const auto& [name, values] : a.figures) names.insert(name);
  for (const auto& [name, values] : b.figures) names.insert(name);
  for (const std::string& name : names) set.figures.push_back(compared(name, a, b, pairs, tolerances));
  return set;
}

/// Whether a tolerance is for a block of metrics.json that a run may lack, and these runs do.
bool is_for_an_absent_block(const std::string& key, const std::set<std::string>& names) {
  for (const std::string_view block : {"gaze.", "right_eye.", "latency.", "clutter."}) {
    if (key.starts_with(block))
      return std::ranges::none_of(names, [&](const std::string& name) { return name.starts_with(block); });
  }
  return false;
}

/// Throws InputError with the tolerances that fit no figure, where there are figures.
void check_tolerances(const std::vector<SeedRuns>& a, const std::vector<SeedRuns>& b,
                      const std::vector<Tolerance>& tolerances) {
  std::set<std::string> names;
  for (const std::vector<SeedRuns>* groups : {&a, &b}) {
    for (const SeedRuns& group : *groups) {
      for (const auto& [name, values] : group.figures) names.insert(name);
    }
  }
  if (names.empty()) return;
  std::vector<Problem> problems;
  for (const Tolerance& tolerance : tolerances) {
    const bool fits =
        std::ranges::any_of(names, [&](const std::string& name) { return matches(tolerance.key, name); });
    if (!fits && !is_for_an_absent_block(tolerance.key, names))
      problems.push_back({"--tolerance", tolerance.key,
                          "a figure of these runs, such as " + *names.begin() + "; --json lists all"});
  }
  if (!problems.empty()) throw InputError(std::move(problems));
}

}  // namespace

Tolerance tolerance_of(const std::string& text) {
  const std::size_t equals = text.find('=');
  Tolerance tolerance;
  if (equals != std::string::npos && equals > 0) {
    tolerance.key = text.substr(0, equals);
    std::string_view number = std::string_view(text).substr(equals + 1);
    tolerance.relative = number.ends_with('%');
    if (tolerance.relative) number.remove_suffix(1);
    if (parse_number(number, tolerance.value) && std::isfinite(tolerance.value) && tolerance.value >= 0.0) {
      if (tolerance.relative) tolerance.value *= 0.01;
      return tolerance;
    }
  }
  throw InputError("--tolerance", text,
                   "KEY=VALUE or KEY=VALUE%, such as gaze.acquire_s=0.05 or detectors.*.recall=2%");
}

bool RunComparison::different() const {
  if (a.failed + b.failed > 0) return true;
  return std::ranges::any_of(sets, [](const ComparedSet& set) {
    return set.seeds_a.empty() || set.seeds_b.empty() ||
           std::ranges::any_of(set.figures, [](const ComparedFigure& f) { return f.changed; });
  });
}

RunComparison compare(RunSet a, RunSet b, const std::vector<Tolerance>& tolerances, bool paired) {
  RunComparison comparison{.a = std::move(a), .b = std::move(b), .sets = {}};
  const std::vector<SeedRuns>& in_a = comparison.a.groups;
  const std::vector<SeedRuns>& in_b = comparison.b.groups;
  check_tolerances(in_a, in_b, tolerances);
  if (in_a.size() == 1 && in_b.size() == 1) {
    comparison.sets.push_back(compared(in_a.front(), in_b.front(), tolerances, paired));
    return comparison;
  }
  for (const SeedRuns& group : in_a) {
    const auto other = std::ranges::find(in_b, group.label, &SeedRuns::label);
    comparison.sets.push_back(other != in_b.end()
                                  ? compared(group, *other, tolerances, paired)
                                  : ComparedSet{.label = group.label, .seeds_a = group.seeds, .seeds_b = {}});
  }
  for (const SeedRuns& group : in_b) {
    if (std::ranges::find(in_a, group.label, &SeedRuns::label) == in_a.end())
      comparison.sets.push_back({.label = group.label, .seeds_a = {}, .seeds_b = group.seeds});
  }
  return comparison;
}

}  // namespace saccade
