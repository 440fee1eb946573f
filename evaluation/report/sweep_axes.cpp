#include "evaluation/report/sweep_axes.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <set>
#include <utility>

#include "evaluation/report/html.h"

namespace saccade::sweep {

std::optional<double> number_of(const std::string& text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool whole = error == std::errc() && end == text.data() + text.size();
  return whole ? std::optional(value) : std::nullopt;
}

namespace {

constexpr std::size_t bin_count = 8;

void put_into_bins(Axis& axis, const Rows& rows, const std::vector<double>& sorted) {
  axis.binned = true;
  const auto scale = [&](double value) { return axis.log ? std::log(value) : value; };
  const auto unscale = [&](double value) { return axis.log ? std::exp(value) : value; };
  const double low = scale(sorted.front());
  const double step = (scale(sorted.back()) - low) / static_cast<double>(bin_count);
  for (std::size_t i = 0; i < bin_count; ++i) {
    const double from = low + step * static_cast<double>(i);
    axis.bins.push_back({short_number(unscale(from)) + " to " + short_number(unscale(from + step)),
                         unscale(from + 0.5 * step),
                         {}});
  }
  for (const SweepRow* row : rows) {
    const double place = (scale(*number_of(row->values[axis.index])) - low) / step;
    const auto bin = std::min(static_cast<std::size_t>(std::max(place, 0.0)), bin_count - 1);
    axis.bins[bin].rows.push_back(row);
  }
}

}  // namespace

Rows done_rows(const SweepTable& table) {
  Rows rows;
  for (const SweepRow& row : table.rows)
    if (row.status == "done") rows.push_back(&row);
  return rows;
}

std::vector<Axis> axes_of(const SweepTable& table, const Rows& rows) {
  constexpr double wide = 7.9;  // from one end to the other
  std::vector<Axis> axes;
  for (std::size_t i = 0; i < table.axes.size(); ++i) {
    if (table.axes[i] == seed_axis) continue;
    Axis axis{i, table.axes[i], true, false, false, {}};
    std::vector<std::string> texts;  // in the order of the plan
    std::vector<double> numbers;
    for (const SweepRow* row : rows) {
      const std::string& text = row->values[i];
      if (std::find(texts.begin(), texts.end(), text) != texts.end()) continue;
      texts.push_back(text);
      const auto number = number_of(text);
      axis.numeric &= number.has_value();
      numbers.push_back(number.value_or(0.0));
    }
    if (texts.size() < 2) continue;
    std::vector<double> sorted = numbers;
    std::sort(sorted.begin(), sorted.end());
    axis.log = axis.numeric && sorted.front() > 0.0 && sorted.back() > wide * sorted.front();
    if (axis.numeric && texts.size() > most_values) {
      put_into_bins(axis, rows, sorted);
    } else {
      for (std::size_t k = 0; k < texts.size(); ++k)
        axis.bins.push_back({texts[k], axis.numeric ? numbers[k] : static_cast<double>(k), {}});
      for (const SweepRow* row : rows) {
        const auto at = std::find(texts.begin(), texts.end(), row->values[i]) - texts.begin();
        axis.bins[static_cast<std::size_t>(at)].rows.push_back(row);
      }
      if (axis.numeric) {
        std::sort(axis.bins.begin(), axis.bins.end(), [](const Bin& a, const Bin& b) { return a.x < b.x; });
      }
    }
    axes.push_back(std::move(axis));
  }
  return axes;
}

Quantity::Of detector_of(const std::string& metric, std::size_t index, std::string& label) {
  constexpr std::string_view prefix = "detectors.";
  label = metric;
  if (!metric.starts_with(prefix)) return {"", index};
  const std::size_t end = metric.find('.', prefix.size());
  if (end == std::string::npos) return {"", index};
  label = metric.substr(end + 1);
  return {metric.substr(prefix.size(), end - prefix.size()), index};
}

std::vector<Quantity> quantities_of(const SweepTable& table) {
  std::vector<Quantity> quantities;
  for (std::size_t i = 0; i < table.metrics.size(); ++i) {
    std::string label;
    Quantity::Of of = detector_of(table.metrics[i], i, label);
    auto same = std::find_if(quantities.begin(), quantities.end(), [&](const Quantity& q) {
      return q.label == label && !of.name.empty() && !q.of.front().name.empty();
    });
    if (same == quantities.end()) same = quantities.insert(same, {label, {}});
    same->of.push_back(std::move(of));
  }
  return quantities;
}

std::vector<std::string> detectors_of(const SweepTable& table) {
  std::vector<std::string> names;
  const auto add = [&](const std::string& name) {
    if (!name.empty() && std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  };
  for (const Quantity& quantity : quantities_of(table))
    for (const Quantity::Of& of : quantity.of) add(of.name);
  for (const SweepRow& row : table.rows)
    for (const auto& [name, curve] : row.curves) add(name);
  return names;
}

MeanSd mean_of(const Rows& rows, std::size_t metric) {
  std::vector<std::optional<double>> values;
  for (const SweepRow* row : rows) values.push_back(row->metrics[metric]);
  return mean_sd_of(values);
}

Rows intersection(const Rows& a, const Rows& b) {
  const std::set<const SweepRow*> in_b(b.begin(), b.end());
  Rows both;
  std::copy_if(a.begin(), a.end(), std::back_inserter(both),
               [&](const SweepRow* row) { return in_b.contains(row); });
  return both;
}

std::vector<Facet> facets_of(const std::vector<Axis>& axes, const Axis& shown, const Rows& rows) {
  std::vector<Facet> facets = {{"", rows}};
  for (const Axis& axis : axes) {
    if (axis.key == shown.key) continue;
    std::vector<Facet> split;
    for (const Facet& facet : facets) {
      for (const Bin& bin : axis.bins) {
        Facet part{facet.label + (facet.label.empty() ? "" : ", ") + axis.key + " " + bin.label,
                   intersection(facet.rows, bin.rows)};
        if (!part.rows.empty()) split.push_back(std::move(part));
      }
    }
    facets = std::move(split);
    if (facets.size() > most_panels || axis.binned) return {{"", rows}};
  }
  return facets;
}

bool is_shown_by_panels(const Axis& axis, const std::vector<Axis>& axes, const Rows& rows) {
  return !axis.numeric && std::any_of(axes.begin(), axes.end(), [&](const Axis& other) {
    return other.numeric && facets_of(axes, other, rows).size() > 1;
  });
}

}  // namespace saccade::sweep
