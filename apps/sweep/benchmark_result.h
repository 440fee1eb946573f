#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "evaluation/scoring/uncertainty.h"
#include "loop/latency.h"

namespace saccade {

/// One run of an entry.
struct BenchmarkRow {
  std::string run;   ///< "ball_2000"
  std::string part;  ///< "ball", "none", or the name of a scenario in whose loop the entry drives the gaze
  bool loop = false;
  std::int64_t seed = 0;
  double duration_s = 0.0;
  std::int64_t events = 0;
  /// Of times, places and polarities. In the loop the events depend on the entry.
  std::string events_digest;
  std::map<std::string, std::string> kinds;  ///< what the world is made of: "sensor" -> "dvs128"
  std::string failure;                       ///< why the detector ended early; empty: it did not
  /// By the names of metrics.json: average_precision, precision, recall, alarm_ratio, alarms_per_min, us_per_event,
  /// streaming_average_precision, on_target_ratio, acquire_s; and reaction_ms, from the first chance to the first inlier at
  /// the threshold. None: does not apply.
  std::map<std::string, std::optional<double>> figures;
  std::int64_t together = 1;  ///< entries whose detectors shared the run, and the processor's caches
  bool had_chance = false;
  std::int64_t observations = 0;           ///< at or above the threshold
  std::optional<Reliability> reliability;  ///< none where the score is no probability

  [[nodiscard]] std::optional<double> figure(const std::string& name) const;
};

/// Everything that is needed to repeat an entry's runs, and what they came to: result.json.
struct BenchmarkResult {
  std::string entry;          ///< name of the detector
  std::string configuration;  ///< YAML of the block `detectors`, on one line
  std::string saccade;        ///< "0.2.0 (9b6774e)"
  std::string machine;
  std::string list;  ///< name
  std::int64_t list_version = 1;
  std::string list_digest;
  bool quick = false;
  std::string latency_machine;  ///< name; empty: the list has no latencies
  std::string latency_class;    ///< of the entry
  WorkTime latency;             ///< of that class
  std::vector<BenchmarkRow> rows;

  /// Digest of the list and of the events of each world: figures of entries with the same one can be compared.
  [[nodiscard]] std::string worlds_digest() const;
};

/// A figure of an entry over its runs.
struct BenchmarkFigure {
  std::string key;
  std::string heading;
  std::optional<double> value;
  /// 95 % of the resampled sets of worlds lie between them; only of average_precision.
  std::optional<double> low, high;
  double factor = 1.0;  ///< of the value in tables: 100 for percent
};

/// Means over worlds (costs: sums over sums), in the order of tables. The interval is a bootstrap with a fixed seed.
[[nodiscard]] std::vector<BenchmarkFigure> figures_of(const std::vector<BenchmarkRow>& rows);

/// Of all worlds together; none where the score is no probability in one of them.
[[nodiscard]] std::optional<Reliability> reliability_of(const std::vector<BenchmarkRow>& rows);

/// Rows with a ball by what their world is made of: kind, value, rows.
struct BenchmarkKind {
  std::string kind;
  std::string value;
  std::vector<BenchmarkRow> rows;
};
[[nodiscard]] std::vector<BenchmarkKind> kinds_of(const std::vector<BenchmarkRow>& rows);

/// Throws RunError.
void write_benchmark_result(const std::filesystem::path& path, const BenchmarkResult& result);
/// Throws InputError for a file that is no result.
[[nodiscard]] BenchmarkResult read_benchmark_result(const std::filesystem::path& path);

/// Results whose figures can be compared.
using BenchmarkGroup = std::vector<BenchmarkResult>;
/// Groups by worlds_digest(), in the order of their first result; in each the best average precision first.
[[nodiscard]] std::vector<BenchmarkGroup> groups_of(std::vector<BenchmarkResult> results);

/// The tables of all groups, in Markdown.
[[nodiscard]] std::string benchmark_table_text(const std::vector<BenchmarkGroup>& groups);
/// The same as a page. Throws RunError.
void write_benchmark_table(const std::vector<BenchmarkGroup>& groups, const std::filesystem::path& file);
/// The page of one result. Throws RunError.
void write_benchmark_page(const BenchmarkResult& result, const std::filesystem::path& file);

}  // namespace saccade
