#include "apps/sweep/benchmark_list.h"

#include <sstream>

#include "config/scenario.h"
#include "config/yaml_reader.h"
#include "recording/file_digest.h"

namespace saccade {
namespace {

std::vector<std::int64_t> seeds_from(std::int64_t first, std::int64_t count) {
  std::vector<std::int64_t> seeds;
  for (std::int64_t i = 0; i < count; ++i) seeds.push_back(first + i);
  return seeds;
}

}  // namespace

void describe(FieldVisitor& v, BenchmarkRuns& runs) {
  constexpr double most = 1e5;
  v.text("worlds", runs.worlds,
         "scenario of a random world, relative to this file; or one that saccade ships");
  v.integer("first_seed", runs.first_seed, {0, 9e15}, "the first seed of worlds and loop");
  v.integer("with_ball", runs.with_ball, {1, most}, "number of worlds with a ball");
  v.integer("without_ball", runs.without_ball, {0, most}, "number of worlds without one");
  v.text("loop", runs.loop, "scenarios in which the entry drives the gaze, separated by blanks");
  v.integer("loop_seeds", runs.loop_seeds, {1, most}, "number of seeds of each of them");
}

void describe(FieldVisitor& v, BenchmarkLatency& latency) {
  v.text("machine", latency.machine, "name of the machine, and where its times come from");
  LatencyConfig& times = latency.times;
  v.real("transport_ms", times.transport_ms, {0.0, 1000.0}, "as in a scenario's section `latency`");
  v.real("actuation_ms", times.actuation_ms, {0.0, 1000.0}, "the same");
  v.real("controller_us", times.controller_us, {0.0, 1e6}, "the same");
  v.integer("max_waiting_events", times.max_waiting_events, {1, 1e6}, "the same");
  v.named_sections("classes", latency.classes,
                   "processing times of detectors by class: the preset of an entry, or what --class states",
                   "a class");
}

void describe(FieldVisitor& v, BenchmarkList& list) {
  v.text("name", list.name, "name of the benchmark");
  v.integer("version", list.version, {1, 1e6}, "a changed list is another version");
  v.section("full", list.full, "the runs of an entry");
  v.section("quick", list.quick, "those of --quick");
  v.optional_section("latency", list.latency,
                     "times of a stated machine, for the streaming score and the loops");
}

BenchmarkList read_benchmark_list(const std::filesystem::path& path) {
  const YamlTree tree = read_yaml_file(path);
  BenchmarkList list;
  YamlReader reader(tree, {"name", "version", "full.first_seed", "full.with_ball", "full.without_ball"});
  describe(reader, list);
  reader.finish();
  list.folder = path.parent_path();
  list.digest = digest_of_file(path);
  return list;
}

std::vector<BenchmarkPart> parts_of(const BenchmarkList& list, bool quick) {
  const BenchmarkRuns& runs = quick ? list.quick : list.full;
  const std::filesystem::path worlds = scenario_file(list.folder, runs.worlds);
  std::vector<BenchmarkPart> parts;
  parts.push_back({"ball", worlds, false, seeds_from(runs.first_seed, runs.with_ball)});
  if (runs.without_ball > 0)
    parts.push_back({"none", worlds, false, seeds_from(runs.first_seed, runs.without_ball)});
  std::istringstream names(runs.loop);
  for (std::string name; names >> name;) {
    const std::filesystem::path file = scenario_file(list.folder, name);
    parts.push_back({file.stem().string(), file, true, seeds_from(runs.first_seed, runs.loop_seeds)});
  }
  return parts;
}

}  // namespace saccade
