#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/config.h"
#include "loop/latency.h"

namespace saccade {

/// The runs of one size of a benchmark.
struct BenchmarkRuns {
  std::string worlds = "random_world";  ///< scenario with the section `world`
  std::int64_t first_seed = 1;          ///< of worlds and loop
  std::int64_t with_ball = 1;           ///< worlds, from first_seed on
  std::int64_t without_ball = 1;
  std::string loop;             ///< scenarios in which the entry drives the gaze, separated by blanks
  std::int64_t loop_seeds = 1;  ///< of each of them, from first_seed on
};

void describe(FieldVisitor& v, BenchmarkRuns& runs);

/// The times of a stated machine: they do not depend on the one that runs the benchmark.
struct BenchmarkLatency {
  std::string machine;  ///< its name, and where the times come from
  LatencyConfig times;  ///< its kind and detectors are not used
  /// Processing times of detectors, by class. The class of an entry is its preset, or is stated.
  std::vector<std::pair<std::string, WorkTime>> classes;
};

void describe(FieldVisitor& v, BenchmarkLatency& latency);

/// What every entry of a benchmark runs.
struct BenchmarkList {
  std::string name;
  std::int64_t version = 1;
  BenchmarkRuns full;
  BenchmarkRuns quick;  ///< for tests; no result of an entry
  std::optional<BenchmarkLatency>
      latency;  ///< of the streaming score and the loops; none: nothing takes time

  std::filesystem::path folder;  ///< of the file: scenarios are relative to it
  std::string digest;            ///< of the file's contents
};

/// Keys of a list file.
void describe(FieldVisitor& v, BenchmarkList& list);

/// Reads a list file. Throws InputError with everything that is wrong; scenarios are not read.
[[nodiscard]] BenchmarkList read_benchmark_list(const std::filesystem::path& path);

/// Runs that differ in their seeds alone.
struct BenchmarkPart {
  std::string name;  ///< ball, none, or the scenario's name; the folder of its runs
  std::filesystem::path scenario;
  bool loop = false;  ///< the entry drives the gaze
  std::vector<std::int64_t> seeds;

  /// The name of a run: "ball_2000".
  [[nodiscard]] std::string run_name(std::int64_t seed) const { return name + "_" + std::to_string(seed); }
};

[[nodiscard]] std::vector<BenchmarkPart> parts_of(const BenchmarkList& list, bool quick);

}  // namespace saccade
