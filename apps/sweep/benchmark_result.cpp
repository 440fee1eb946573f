#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <utility>

#include "apps/sweep/benchmark_result.h"
#include "core/error.h"
#include "core/random.h"
#include "evaluation/scoring/statistics.h"
#include "recording/file_digest.h"
#include "recording/output_file.h"

namespace saccade {
namespace {

using Json = nlohmann::ordered_json;
using Values = std::vector<double>;

constexpr int result_schema = 1;
constexpr std::size_t resamples = 2000;
constexpr double interval = 0.95;

Values values_of(const std::vector<BenchmarkRow>& rows, const std::string& figure) {
  Values values;
  for (const BenchmarkRow& row : rows) {
    if (const auto value = row.figure(figure)) values.push_back(*value);
  }
  return values;
}

std::optional<double> mean_of(const Values& values) {
  if (values.empty()) return std::nullopt;
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

/// Bootstrap over worlds: the quantiles of the means of sets drawn with replacement.
std::pair<std::optional<double>, std::optional<double>> interval_of(const Values& values) {
  if (values.size() < 2) return {};
  const RandomStream random(1, "benchmark bootstrap");
  Values means;
  for (std::size_t i = 0; i < resamples; ++i) {
    double sum = 0.0;
    for (std::size_t k = 0; k < values.size(); ++k) sum += values[random.bits(i, k) % values.size()];
    means.push_back(sum / static_cast<double>(values.size()));
  }
  const auto low = quantile(means, 0.5 * (1.0 - interval));
  return {low, quantile(means, 0.5 * (1.0 + interval))};
}

std::vector<BenchmarkRow> rows_where(const std::vector<BenchmarkRow>& rows, const auto& condition) {
  std::vector<BenchmarkRow> chosen;
  std::ranges::copy_if(rows, std::back_inserter(chosen), condition);
  return chosen;
}

/// The share of the worlds with a chance in which the reaction was faster.
std::optional<double> share_below(const std::vector<BenchmarkRow>& rows, double ms) {
  std::int64_t chances = 0;
  std::int64_t faster = 0;
  for (const BenchmarkRow& row : rows) {
    if (!row.had_chance) continue;
    ++chances;
    const auto reaction_ms = row.figure("reaction_ms");
    if (reaction_ms && *reaction_ms < ms) ++faster;
  }
  if (chances == 0) return std::nullopt;
  return static_cast<double>(faster) / static_cast<double>(chances);
}

Json json_of(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

/// Of each bin the observations, the inliers and the mean score.
Json json_of(const std::optional<Reliability>& reliability) {
  if (!reliability) return nullptr;
  Json bins = Json::array();
  for (const ReliabilityBin& bin : *reliability)
    bins.push_back({bin.observations, bin.inliers, bin.observations > 0 ? bin.mean_score : 0.0});
  return bins;
}

std::optional<Reliability> reliability_in(const Json& json) {
  if (json.is_null()) return std::nullopt;
  Reliability bins;
  for (std::size_t i = 0; i < bins.size(); ++i) {
    json.at(i).at(0).get_to(bins[i].observations);
    json.at(i).at(1).get_to(bins[i].inliers);
    json.at(i).at(2).get_to(bins[i].mean_score);
  }
  return bins;
}

Json json_of(const BenchmarkRow& row) {
  Json json{{"run", row.run},
            {"part", row.part},
            {"loop", row.loop},
            {"seed", row.seed},
            {"duration_s", row.duration_s},
            {"events", row.events},
            {"events_digest", row.events_digest},
            {"together", row.together},
            {"had_chance", row.had_chance},
            {"failure", row.failure},
            {"observations", row.observations},
            {"reliability", json_of(row.reliability)},
            {"kinds", row.kinds}};
  for (const auto& [name, value] : row.figures) json["figures"][name] = json_of(value);
  return json;
}

Json latency_of(const BenchmarkResult& result) {
  if (result.latency_machine.empty()) return nullptr;
  return {{"machine", result.latency_machine},
          {"class", result.latency_class},
          {"per_call_us", result.latency.per_call_us},
          {"per_event_us", result.latency.per_event_us}};
}

BenchmarkRow row_in(const Json& json) {
  BenchmarkRow row;
  json.at("run").get_to(row.run);
  json.at("part").get_to(row.part);
  json.at("loop").get_to(row.loop);
  json.at("seed").get_to(row.seed);
  json.at("duration_s").get_to(row.duration_s);
  json.at("events").get_to(row.events);
  json.at("events_digest").get_to(row.events_digest);
  json.at("together").get_to(row.together);
  json.at("had_chance").get_to(row.had_chance);
  json.at("failure").get_to(row.failure);
  json.at("observations").get_to(row.observations);
  row.reliability = reliability_in(json.at("reliability"));
  json.at("kinds").get_to(row.kinds);
  for (const auto& [name, value] : json.at("figures").items())
    row.figures[name] = value.is_null() ? std::nullopt : std::optional(value.get<double>());
  return row;
}

}  // namespace

std::optional<double> BenchmarkRow::figure(const std::string& name) const {
  const auto at = figures.find(name);
  return at == figures.end() ? std::nullopt : at->second;
}

std::string BenchmarkResult::worlds_digest() const {
  std::string text = list_digest;
  for (const BenchmarkRow& row : rows) {
    if (!row.loop) text += "\n" + row.run + " " + row.events_digest;
  }
  return digest(text);
}

std::vector<BenchmarkFigure> figures_of(const std::vector<BenchmarkRow>& rows) {
  const auto with_ball = rows_where(rows, [](const auto& row) { return row.part == "ball"; });
  const auto without = rows_where(rows, [](const auto& row) { return row.part == "none"; });
  const auto loop = rows_where(rows, [](const auto& row) { return row.loop; });
  const Values precision = values_of(with_ball, "average_precision");
  const auto [low, high] = interval_of(precision);
  Values reaction_ms = values_of(with_ball, "reaction_ms");
  double us = 0.0;
  double events = 0.0;
  double ms = 0.0;
  Values together;
  for (const BenchmarkRow& row : rows) {
    if (!row.loop) together.push_back(static_cast<double>(row.together));
    const auto us_per_event = row.figure("us_per_event");
    if (!us_per_event) continue;
    us += *us_per_event * static_cast<double>(row.events);
    events += static_cast<double>(row.events);
    ms += 1e3 * row.duration_s;
  }
  const auto ratio = [us](double of) { return of > 0.0 ? std::optional(us / of) : std::nullopt; };
  constexpr double percent = 100.0;
  return {
      {"average_precision", "average precision", mean_of(precision), low, high},
      {"streaming_average_precision",
       "streaming average precision",
       mean_of(values_of(with_ball, "streaming_average_precision")),
       {},
       {}},
      {"recall", "recall", mean_of(values_of(with_ball, "recall")), {}, {}},
      {"precision", "precision", mean_of(values_of(with_ball, "precision")), {}, {}},
      {"alarm_ratio", "alarm share, %", mean_of(values_of(without, "alarm_ratio")), {}, {}, percent},
      {"alarms_per_min", "alarms per min", mean_of(values_of(without, "alarms_per_min")), {}, {}},
      {"reaction_ms", "reaction, median, ms", quantile(reaction_ms, 0.5), {}, {}},
      {"reaction_below_10_ms", "below 10 ms, %", share_below(with_ball, 10.0), {}, {}, percent},
      {"reaction_below_100_ms", "below 100 ms, %", share_below(with_ball, 100.0), {}, {}, percent},
      {"on_target_ratio", "on target, %", mean_of(values_of(loop, "on_target_ratio")), {}, {}, percent},
      {"us_per_event", "µs per event", ratio(events), {}, {}},
      {"us_per_ms", "µs per ms", ratio(ms), {}, {}},
      {"entries_together", "entries together", mean_of(together), {}, {}},
  };
}

std::optional<Reliability> reliability_of(const std::vector<BenchmarkRow>& rows) {
  std::optional<Reliability> sum;
  for (const BenchmarkRow& row : rows) {
    if (row.loop) continue;
    if (!row.reliability && row.observations > 0) return std::nullopt;
    if (!row.reliability) continue;
    if (!sum) sum.emplace();
    for (std::size_t i = 0; i < sum->size(); ++i) {
      ReliabilityBin& bin = (*sum)[i];
      const ReliabilityBin& own = (*row.reliability)[i];
      bin.observations += own.observations;
      bin.inliers += own.inliers;
      if (own.observations == 0) continue;
      const double share = static_cast<double>(own.observations) / static_cast<double>(bin.observations);
      bin.mean_score += share * (own.mean_score - bin.mean_score);
    }
  }
  return sum;
}

std::vector<BenchmarkKind> kinds_of(const std::vector<BenchmarkRow>& rows) {
  std::map<std::pair<std::string, std::string>, std::vector<BenchmarkRow>> groups;
  for (const BenchmarkRow& row : rows) {
    if (row.part != "ball") continue;
    for (const auto& kind : row.kinds) groups[kind].push_back(row);
  }
  std::vector<BenchmarkKind> kinds;
  kinds.reserve(groups.size());
  for (auto& [kind, of] : groups) kinds.push_back({kind.first, kind.second, std::move(of)});
  return kinds;
}

void write_benchmark_result(const std::filesystem::path& path, const BenchmarkResult& result) {
  Json json{{"benchmark_schema", result_schema},
            {"entry", result.entry},
            {"configuration", result.configuration},
            {"saccade", result.saccade},
            {"machine", result.machine},
            {"list",
             {{"name", result.list},
              {"version", result.list_version},
              {"digest", result.list_digest},
              {"quick", result.quick}}},
            {"latency", latency_of(result)},
            {"worlds_digest", result.worlds_digest()}};
  for (const BenchmarkFigure& figure : figures_of(result.rows)) {
    json["figures"][figure.key] = json_of(figure.value);
    if (figure.low) json["figures"][figure.key + "_interval"] = {json_of(figure.low), json_of(figure.high)};
  }
  json["figures"]["reliability"] = json_of(reliability_of(result.rows));
  std::string text = json.dump(1);
  text.resize(text.size() - 2);  // without its last line, the brace
  text += ",\n \"runs\": [";
  for (std::size_t i = 0; i < result.rows.size(); ++i)
    text += (i == 0 ? "\n  " : ",\n  ") + json_of(result.rows[i]).dump();
  write_file(path, text + "\n ]\n}\n");
}

BenchmarkResult read_benchmark_result(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw InputError(path.string(), "no file that can be read", "the result.json of an entry");
  try {
    const Json json = Json::parse(file);
    if (const int found = json.at("benchmark_schema").get<int>(); found != result_schema)
      throw InputError(path.string(), fmt::format("benchmark_schema {}", found),
                       std::to_string(result_schema));
    BenchmarkResult result;
    json.at("entry").get_to(result.entry);
    json.at("configuration").get_to(result.configuration);
    json.at("saccade").get_to(result.saccade);
    json.at("machine").get_to(result.machine);
    const Json& list = json.at("list");
    list.at("name").get_to(result.list);
    list.at("version").get_to(result.list_version);
    list.at("digest").get_to(result.list_digest);
    list.at("quick").get_to(result.quick);
    if (const Json& latency = json.at("latency"); !latency.is_null()) {
      latency.at("machine").get_to(result.latency_machine);
      latency.at("class").get_to(result.latency_class);
      latency.at("per_call_us").get_to(result.latency.per_call_us);
      latency.at("per_event_us").get_to(result.latency.per_event_us);
    }
    for (const Json& row : json.at("runs")) result.rows.push_back(row_in(row));
    return result;
  } catch (const Json::exception& error) {
    throw InputError(path.string(), error.what(), "the result.json of an entry");
  }
}

std::vector<BenchmarkGroup> groups_of(std::vector<BenchmarkResult> results) {
  std::vector<BenchmarkGroup> groups;
  for (BenchmarkResult& result : results) {
    const std::string digest = result.worlds_digest();
    const auto same = std::ranges::find_if(
        groups, [&](const BenchmarkGroup& group) { return group.front().worlds_digest() == digest; });
    (same == groups.end() ? groups.emplace_back() : *same).push_back(std::move(result));
  }
  const auto score = [](const BenchmarkResult& result) { return figures_of(result.rows)[0].value; };
  for (BenchmarkGroup& group : groups) std::ranges::stable_sort(group, std::ranges::greater{}, score);
  return groups;
}

}  // namespace saccade
