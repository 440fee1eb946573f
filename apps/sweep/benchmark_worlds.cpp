#include "apps/sweep/benchmark_worlds.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "apps/sweep/sweep_coordinator.h"
#include "apps/sweep/sweep_folder.h"
#include "apps/sweep/sweep_run.h"
#include "core/error.h"
#include "evaluation/scoring/metrics.h"
#include "recording/file_lock.h"
#include "recording/output_file.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;

using EntryRefs = std::vector<const BenchmarkEntry*>;

YamlNode number(double value) { return yaml_scalar(fmt::format("{}", value)); }

void add(YamlNode& map, const std::string& key, YamlNode value) {
  map.keys.push_back(key);
  map.items.push_back(std::move(value));
}

std::string preset_of(const BenchmarkEntry& entry, const Registry& registry) {
  const YamlNode& keys = entry.detectors.items.front();
  if (const YamlNode* preset = keys.entry("preset")) return preset->text;
  for (const std::string& name : registry.detectors.names()) {
    const std::string& selecting = registry.detectors.rows().find(name)->selecting_key;
    if (!selecting.empty() && keys.entry(selecting) != nullptr) return name;
  }
  return entry.name;
}

YamlNode latency_block(const BenchmarkLatency& latency, const EntryRefs& entries, bool loop) {
  YamlNode block = YamlNode::of(YamlNode::Kind::map);
  add(block, "kind", yaml_scalar("model"));
  add(block, "transport_ms", number(latency.times.transport_ms));
  add(block, "actuation_ms", number(latency.times.actuation_ms));
  add(block, "controller_us", number(latency.times.controller_us));
  add(block, "max_waiting_events", yaml_scalar(std::to_string(latency.times.max_waiting_events)));
  YamlNode detectors = YamlNode::of(YamlNode::Kind::map);
  for (const BenchmarkEntry* entry : entries) {
    const WorkTime work = work_of(latency, entry->latency_class);
    YamlNode times = YamlNode::of(YamlNode::Kind::map);
    add(times, "per_call_us", number(work.per_call_us));
    add(times, "per_event_us", number(work.per_event_us));
    add(detectors, loop ? entry->name : with_latency(entry->name), std::move(times));
  }
  add(block, "detectors", std::move(detectors));
  return block;
}

/// The sweep over the seeds of a part, with the entries as its only detectors.
SweepConfig sweep_of(const BenchmarkPart& part, const EntryRefs& entries, const BenchmarkList& list,
                     const Registry& registry) {
  const std::string own = "the benchmark's own setting";
  SweepConfig config;
  config.name = part.name;
  config.scenario = part.scenario;
  YamlNode detectors = YamlNode::of(YamlNode::Kind::map);
  for (const BenchmarkEntry* entry : entries) {
    YamlNode keys = entry->detectors.items.front();
    add(detectors, entry->name, keys);
    if (!list.latency || part.loop) continue;
    if (keys.kind != YamlNode::Kind::map) keys = YamlNode::of(YamlNode::Kind::map);
    if (keys.entry("preset") == nullptr) add(keys, "preset", yaml_scalar(preset_of(*entry, registry)));
    add(detectors, with_latency(entry->name), std::move(keys));
  }
  config.set.push_back({"detectors", std::move(detectors), entries.front()->place});
  config.set.push_back({"frame_30hz", YamlNode::of(YamlNode::Kind::nothing), own});
  if (list.latency) config.set.push_back({"latency", latency_block(*list.latency, entries, part.loop), own});
  if (part.loop) {
    config.set.push_back({"gaze.detector", yaml_scalar(entries.front()->name), own});
  } else {
    config.set.push_back({"world.with_ball", yaml_scalar(part.name == "ball" ? "always" : "never"), own});
  }
  SweepAxis axis{.key = "seed", .place = own, .values = {}};
  for (const std::int64_t seed : part.seeds) {
    const std::string text = std::to_string(seed);
    axis.values.push_back({text, {{"seed", yaml_scalar(text), own}}});
  }
  config.axes.push_back(std::move(axis));
  config.report.worst = 0;
  return config;
}

/// What is said of one entry in the metrics of a run of several.
Metrics metrics_of(Metrics metrics, const std::string& entry) {
  const std::set<std::string> own = {entry, with_latency(entry)};
  std::erase_if(metrics.detectors, [&](const auto& detector) { return !own.contains(detector.first); });
  if (metrics.latency)
    std::erase_if(metrics.latency->detectors,
                  [&](const auto& detector) { return !own.contains(detector.name); });
  std::erase_if(metrics.files, [&](const FileDigest& file) {
    constexpr std::string_view block = "detectors.";
    if (!file.key.starts_with(block)) return false;
    const std::string rest = file.key.substr(block.size());
    return !own.contains(rest.substr(0, rest.find('.')));
  });
  return metrics;
}

/// Worlds of a part that the same entries lack.
struct SharedWorlds {
  std::vector<std::size_t> entries;
  std::vector<std::size_t> runs;  ///< of the part
};

std::vector<SharedWorlds> missing_worlds(const std::vector<PlannedEntry>& entries, std::size_t part,
                                         bool retry) {
  const std::size_t runs = entries.front().parts[part].plan.runs.size();
  std::map<std::vector<std::size_t>, std::vector<std::size_t>> groups;
  for (std::size_t run = 0; run < runs; ++run) {
    std::vector<std::size_t> lacking;
    for (std::size_t i = 0; i < entries.size(); ++i) {
      const PlannedPart& planned = entries[i].parts[part];
      const SweepFolder folder(entries[i].folder / planned.part.name);
      const std::string& id = planned.plan.runs[run].id;
      const bool failed = fs::exists(folder.run(id) / "failure.txt");
      if (retry && failed ? !fs::exists(folder.run(id) / "metrics.json") : !folder.has_result(id))
        lacking.push_back(i);
    }
    if (lacking.size() > 1) groups[lacking].push_back(run);
  }
  std::vector<SharedWorlds> worlds;
  worlds.reserve(groups.size());
  for (auto& [lacking, of] : groups) worlds.push_back({lacking, std::move(of)});
  return worlds;
}

/// Gives each entry its part of a run of several.
class HandOver {
 public:
  HandOver(const std::vector<PlannedEntry>& entries, std::size_t part, const SharedWorlds& worlds,
           const SweepPlan& shared)
      : entries_(entries), part_(part), worlds_(worlds), shared_(shared), done_(worlds.runs.size(), false) {}

  void pass_new_results(const SweepFolder& from) {
    for (std::size_t i = 0; i < worlds_.runs.size(); ++i) {
      if (done_[i] || !from.has_result(shared_.runs[i].id)) continue;
      const fs::path run = from.run(shared_.runs[i].id);
      done_[i] = true;
      if (!fs::exists(run / "metrics.json")) continue;  // it failed
      const Metrics metrics = read_metrics(run / "metrics.json");
      for (const std::size_t entry : worlds_.entries) pass(run, metrics, entries_[entry], worlds_.runs[i]);
    }
  }

  void remove_passed(const SweepFolder& from) const {
    for (std::size_t i = 0; i < worlds_.runs.size(); ++i) {
      const fs::path run = from.run(shared_.runs[i].id);
      if (done_[i] && fs::exists(run / "metrics.json")) fs::remove_all(run);
    }
  }

 private:
  void pass(const fs::path& run, const Metrics& metrics, const PlannedEntry& entry,
            std::size_t number) const {
    const PlannedPart& planned = entry.parts[part_];
    const PlannedRun& own = planned.plan.runs[number];
    const SweepFolder to(entry.folder / planned.part.name);
    const fs::path folder = to.run(own.id);
    fs::create_directories(folder);
    const FileLock lock(to.path() / "lock");
    if (!lock.held())
      throw InputError(to.path().string(), "a sweep at work in it", "another folder, or wait for its end");
    write_file(folder / "scenario.yaml", own.scenario);
    fs::copy_file(run / "benchmark.json", folder / "benchmark.json", fs::copy_options::overwrite_existing);
    fs::remove(folder / "failure.txt");
    write_metrics(folder / "metrics.json",
                  metrics_of(metrics, entry.entry.name));  // the last: it makes the run one with a result
  }

  const std::vector<PlannedEntry>& entries_;
  std::size_t part_;
  const SharedWorlds& worlds_;
  const SweepPlan& shared_;
  std::vector<bool> done_;
};

}  // namespace

YamlNode yaml_scalar(const std::string& text) {
  YamlNode node = YamlNode::of(YamlNode::Kind::scalar);
  node.text = text;
  return node;
}

std::string with_latency(const std::string& entry) { return entry + "__streaming"; }

std::string latency_class_of(const BenchmarkEntry& entry, const BenchmarkList& list,
                             const std::string& stated, const Registry& registry) {
  if (!list.latency) {
    if (stated.empty()) return {};
    throw InputError("--class", stated, "a list with the section latency");
  }
  std::vector<std::string> names;
  for (const auto& [name, work] : list.latency->classes) names.push_back(name);
  std::string found = stated.empty() ? preset_of(entry, registry) : stated;
  if (std::ranges::find(names, found) != names.end()) return found;
  if (!stated.empty()) throw InputError("--class", stated, expectation_of(names));
  throw InputError(entry.place, "the preset " + found + ", for which the list has no latencies",
                   "--class with " + expectation_of(names));
}

WorkTime work_of(const BenchmarkLatency& latency, std::string_view name) {
  const auto found =
      std::ranges::find(latency.classes, name, [](const auto& one) { return std::string_view(one.first); });
  SACCADE_CHECK(found != latency.classes.end());
  return found->second;
}

std::vector<PlannedPart> plan_entry(std::vector<BenchmarkPart> parts, const BenchmarkEntry& entry,
                                    const BenchmarkList& list, const std::string& version,
                                    const Registry& registry) {
  std::vector<PlannedPart> planned;
  std::vector<Problem> problems;
  for (BenchmarkPart& part : parts) {
    try {
      SweepPlan plan = plan_sweep(sweep_of(part, {&entry}, list, registry), version, registry);
      planned.push_back({std::move(part), std::move(plan)});
    } catch (const InputError& error) {
      for (const Problem& problem : error.problems()) {
        const auto same = [&](const Problem& known) { return known.text() == problem.text(); };
        if (std::ranges::none_of(problems, same)) problems.push_back(problem);
      }
    }
  }
  if (!problems.empty()) throw InputError(std::move(problems));
  return planned;
}

void make_worlds(const std::vector<PlannedEntry>& entries, const BenchmarkList& list, const fs::path& folder,
                 const SweepEngineConfig& engine, bool retry, const std::string& version,
                 const Registry& registry) {
  for (std::size_t number = 0; number < entries.front().parts.size(); ++number) {
    const BenchmarkPart& part = entries.front().parts[number].part;
    if (part.loop) continue;
    for (const SharedWorlds& worlds : missing_worlds(entries, number, retry)) {
      BenchmarkPart shared = part;
      shared.seeds.clear();
      for (const std::size_t run : worlds.runs) shared.seeds.push_back(part.seeds[run]);
      EntryRefs together;
      for (const std::size_t entry : worlds.entries) together.push_back(&entries[entry].entry);
      const SweepPlan plan = plan_sweep(sweep_of(shared, together, list, registry), version, registry);
      HandOver hand_over(entries, number, worlds, plan);
      fmt::print(stderr, "{} entries together, {}: ", together.size(), part.name);
      make_sweep(
          plan, folder / part.name, engine, false, {"--benchmark"},
          [&](SweepCoordinator&, const SweepFolder& from) {
            hand_over.pass_new_results(from);
            hand_over.remove_passed(from);
          },
          [&](SweepCoordinator& coordinator, const SweepFolder& from) {
            coordinator.set_watch(
                [&hand_over, from](const SweepCoordinator&) { hand_over.pass_new_results(from); });
          });
    }
  }
}

}  // namespace saccade
