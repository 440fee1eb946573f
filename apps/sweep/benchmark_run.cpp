#include "apps/sweep/benchmark_run.h"

#include <fmt/format.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <thread>

#include "apps/sweep/sweep_coordinator.h"
#include "apps/sweep/sweep_run.h"
#include "config/scenario.h"
#include "core/config.h"
#include "core/error.h"
#include "evaluation/report/resolved_scenario.h"
#include "evaluation/scoring/metrics.h"
#include "recording/event_file.h"
#include "recording/output_file.h"
#include "recording/run_files.h"
#include "session/summary.h"
#include "session/version.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

std::string machine_text() {
  std::ifstream file("/proc/cpuinfo");
  std::string model = "unknown processor";
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with("model name")) continue;
    model = line.substr(std::min(line.find(": ") + 2, line.size()));
    break;
  }
  utsname system{};
  ::uname(&system);
  return fmt::format("{}, {} processors, {} {}", model, std::thread::hardware_concurrency(),
                     std::string(system.sysname), std::string(system.machine));
}

/// What a world is made of; nothing where a key does not apply.
std::map<std::string, std::string> kinds_in(const ResolvedKeys& keys) {
  std::map<std::string, std::string> kinds;
  const auto add = [&](const char* kind, const char* key) {
    if (const auto at = keys.find(key); at != keys.end()) kinds[kind] = at->second;
  };
  add("ball", "ball.pattern");
  add("hand", "ball.hand");
  add("room", "lab.clutter");
  add("sensor", "emulator.preset");
  const auto width = keys.find("camera.width_px");
  const auto height = keys.find("camera.height_px");
  if (width != keys.end() && height != keys.end()) kinds["image"] = width->second + " x " + height->second;
  return kinds;
}

BenchmarkRow row_of(const BenchmarkPart& part, const PlannedRun& run, const fs::path& folder,
                    const std::string& entry) {
  const Metrics metrics = read_metrics(folder / "metrics.json");
  BenchmarkRow row;
  row.run = part.run_name(run.seed);
  row.part = part.name;
  row.loop = part.loop;
  row.seed = run.seed;
  row.duration_s = metrics.duration_s;
  row.events = metrics.event_count;
  row.kinds = kinds_in(read_resolved_keys(folder));
  const auto add_streaming = [&](const DetectorScore& score) {
    if (score.streaming) row.figures["streaming_average_precision"] = score.streaming->average_precision;
  };
  for (const auto& [name, score] : metrics.detectors) {
    if (name == with_latency(entry)) {
      add_streaming(score);
      if (row.failure.empty()) row.failure = score.failure;
    }
    if (name != entry) continue;
    row.failure = score.failure;
    add_streaming(score);
    row.figures["average_precision"] = score.average_precision;
    row.figures["precision"] = score.precision;
    row.figures["recall"] = score.recall;
    row.figures["alarm_ratio"] = score.alarm_ratio;
    row.figures["alarms_per_min"] = score.alarms_per_min;
    row.figures["us_per_event"] = score.us_per_event;
    row.had_chance = score.chances > 0;
    row.observations = score.observations;
    row.reliability = score.reliability;
  }
  if (metrics.gaze) {
    // A gaze that never acquired the ball was on it for no time.
    row.figures["on_target_ratio"] = metrics.gaze->score.on_target_ratio.value_or(0.0);
    row.figures["acquire_s"] = metrics.gaze->score.acquire_s;
  }
  std::ifstream file(folder / "benchmark.json");
  try {
    const Json json = Json::parse(file);
    json.at("events_digest").get_to(row.events_digest);
    const Json& reaction_ms = json.at("reaction_ms").at(entry);
    row.together = 0;
    for (const auto& [name, value] : json.at("reaction_ms").items())
      row.together += name.ends_with(with_latency("")) ? 0 : 1;
    row.figures["reaction_ms"] =
        reaction_ms.is_null() ? std::nullopt : std::optional(reaction_ms.get<double>());
  } catch (const Json::exception& error) {
    throw RunError((folder / "benchmark.json").string() + ": cannot be read: " + error.what());
  }
  return row;
}

/// The rows of an entry; none where a run failed.
std::vector<BenchmarkRow> make_rows(const std::vector<PlannedPart>& parts, const fs::path& folder,
                                    const std::string& entry, const BenchmarkOptions& options) {
  std::vector<BenchmarkRow> rows;
  std::int64_t failed = 0;
  for (const PlannedPart& part : parts) {
    fmt::print(stderr, "{}, {}: ", entry, part.part.name);
    const fs::path out = folder / part.part.name;
    make_sweep(part.plan, out, options.engine, options.retry, {"--benchmark"},
               [&](SweepCoordinator& coordinator, const SweepFolder& sweep) {
                 const std::int64_t bad = coordinator.store().count("failed");
                 failed += bad;
                 if (bad > 0) return;
                 for (const PlannedRun& run : part.plan.runs)
                   rows.push_back(row_of(part.part, run, sweep.run(run.id), entry));
               });
  }
  if (failed == 0) return rows;
  fmt::print(
      stderr,
      "saccade: {}: {} runs failed, so there is no result; each has a failure.txt in PART/runs/ID, and "
      "--retry makes them again\n",
      folder.string(), failed);
  return {};
}

/// Throws InputError for a folder that something else made.
void check_folder(const fs::path& out) {
  std::error_code ignored;
  if (fs::exists(out, ignored) && !fs::is_directory(out, ignored))
    throw InputError(out.string(), "a file", "a folder for the benchmark");
}

BenchmarkResult result_of(const BenchmarkEntry& entry, const BenchmarkList& list, bool quick) {
  BenchmarkResult result;
  result.entry = entry.name;
  result.configuration = entry.detectors.one_line();
  result.saccade = fmt::format("{} ({})", version(), commit());
  result.machine = machine_text();
  result.list = list.name;
  result.list_version = list.version;
  result.list_digest = list.digest;
  result.quick = quick;
  if (list.latency) {
    result.latency_machine = list.latency->machine;
    result.latency_class = entry.latency_class;
    result.latency = work_of(*list.latency, entry.latency_class);
  }
  return result;
}

/// Of each part the first seed and every tenth after it.
void keep_a_tenth(std::vector<BenchmarkPart>& parts) {
  constexpr std::size_t step = 10;
  for (BenchmarkPart& part : parts) {
    std::vector<std::int64_t> kept;
    for (std::size_t i = 0; i < part.seeds.size(); i += step) kept.push_back(part.seeds[i]);
    part.seeds = std::move(kept);
  }
}

/// How a repeated run differs, one line each.
std::vector<std::string> differences(const BenchmarkRow& before, const BenchmarkRow& now) {
  std::vector<std::string> lines;
  if (!now.loop && now.events_digest != before.events_digest)
    lines.push_back(
        fmt::format("{}: events {}, in the result {}", now.run, now.events_digest, before.events_digest));
  const auto text = [](const std::optional<double>& value) {
    return value ? fmt::format("{:.4f}", *value) : std::string("none");
  };
  for (const auto& [name, value] : now.figures) {
    if (name == clock_figure) continue;
    const std::optional<double> was = before.figure(name);
    const bool equal =
        was && value ? std::abs(*was - *value) <= verify_tolerance : was.has_value() == value.has_value();
    if (!equal)
      lines.push_back(fmt::format("{}: {} {}, in the result {}", now.run, name, text(value), text(was)));
  }
  return lines;
}

void append_bytes(std::string& bytes, auto value) {
  for (std::size_t i = 0; i < sizeof(value); ++i)
    bytes.push_back(static_cast<char>(static_cast<std::uint64_t>(value) >> (8 * i) & 0xff));
}

/// Of times, places, polarities and cameras, whatever the format and the version that wrote the file.
std::string digest_of_events(const fs::path& file) {
  const auto reader = open_event_file(file);
  constexpr std::size_t chunk = 1 << 16;
  std::vector<Event> events;
  std::string digests;
  while (events.clear(), reader->read(events, chunk) > 0) {
    std::string bytes;
    for (const Event& event : events) {
      append_bytes(bytes, event.t_us);
      append_bytes(bytes, event.x);
      append_bytes(bytes, event.y);
      bytes.push_back(static_cast<char>(event.on));
      bytes.push_back(static_cast<char>(event.camera));
    }
    digests += digest(bytes);
  }
  return digest(digests);
}

/// From the first chance to the first inlier at the threshold; none without either.
std::optional<double> reaction_ms(const std::vector<TruthRow>& truth,
                                  const std::vector<std::optional<bool>>& found) {
  std::optional<std::int64_t> first_us;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (!found[i]) continue;
    if (!first_us) first_us = truth[i].t_us;
    if (*found[i]) return static_cast<double>(truth[i].t_us - *first_us) * 1e-3;
  }
  return std::nullopt;
}

}  // namespace

BenchmarkEntry benchmark_entry(const std::string& text, const Registry& registry) {
  const auto block = [](const std::string& name, YamlNode node) {
    YamlNode map = YamlNode::of(YamlNode::Kind::map);
    map.keys.push_back(name);
    map.items.push_back(std::move(node));
    return map;
  };
  if (registry.detectors.has(text))
    return {text, block(text, YamlNode::of(YamlNode::Kind::map)), "the entry " + text};
  std::error_code ignored;
  const auto in_program = [&](const std::string& name, const char* key, const std::string& value) {
    if (!is_name(name)) throw InputError("saccade benchmark", text, "a name of letters, digits and _");
    return BenchmarkEntry{name, block(name, block(key, yaml_scalar(value))), "the entry " + text};
  };
  if (const std::size_t colon = text.rfind(".py:"); colon != std::string::npos) {
    const std::string file = text.substr(0, colon + 3);
    const std::string name = text.substr(colon + 4);
    if (!fs::is_regular_file(file, ignored))
      throw InputError("saccade benchmark", file, "a Python file, in which the class " + name + " is");
    return in_program(name, "python", fs::absolute(file).string() + ":" + name);
  }
  if (!fs::is_regular_file(text, ignored)) {
    throw InputError(
        "saccade benchmark", text,
        "a file of detectors, FILE.py:CLASS, a program, or " + expectation_of(registry.detectors.names()));
  }
  const fs::path path(text);
  if (path.extension() != ".yaml" && path.extension() != ".yml" && ::access(text.c_str(), X_OK) == 0)
    return in_program(path.stem().string(), "command", fs::absolute(path).string());
  const NamedDetectors named = read_detectors(text, {}, registry.detectors);
  if (named.size() != 1)
    throw InputError(text, fmt::format("{} detectors", named.size()), "one detector in a file");
  const std::string& name = named.front().first;
  // Its paths are absolute now. A radius that the file does not give is that of each world.
  YamlTree resolved = parse_yaml(resolved_detectors(named), text);
  if (read_yaml_file(text).root.find("detectors." + name + ".radius_px") == nullptr &&
      resolved.root.find("detectors." + name + ".radius_px") != nullptr)
    remove_node(resolved, "detectors." + name + ".radius_px");
  return {name, *resolved.root.find("detectors"), text};
}

int benchmark(const std::vector<std::string>& entries, const BenchmarkOptions& options,
              const Registry& registry) {
  check_engine(options.engine);
  check_folder(options.out);
  const BenchmarkList list = read_benchmark_list(options.list);
  std::vector<PlannedEntry> planned;
  std::set<std::string> names;
  for (const std::string& text : entries) {
    BenchmarkEntry entry = benchmark_entry(text, registry);
    if (!names.insert(entry.name).second || !names.insert(with_latency(entry.name)).second)
      throw InputError("saccade benchmark", "two entries with the name " + entry.name, "another name");
    entry.latency_class = latency_class_of(entry, list, options.latency_class, registry);
    auto parts = plan_entry(parts_of(list, options.quick), entry, list, options.version, registry);
    const fs::path folder = options.out / entry.name;
    planned.push_back({std::move(entry), std::move(parts), folder});
  }
  // No entry has this name.
  make_worlds(planned, list, options.out / "side-by-side", options.engine, options.retry, options.version,
              registry);
  bool whole = true;
  std::vector<BenchmarkResult> results;
  for (const PlannedEntry& one : planned) {
    const fs::path& folder = one.folder;
    BenchmarkResult result = result_of(one.entry, list, options.quick);
    result.rows = make_rows(one.parts, folder, one.entry.name, options);
    if (result.rows.empty()) {
      whole = false;
      continue;
    }
    write_benchmark_result(folder / "result.json", result);
    write_benchmark_page(result, folder / "report.html");
    results.push_back(std::move(result));
  }
  fmt::print("{}", benchmark_table_text(groups_of(std::move(results))));
  for (const PlannedEntry& one : planned)
    if (fs::exists(one.folder / "report.html")) print_page(one.folder);
  return whole ? 0 : 1;
}

int verify_benchmark(const fs::path& file, const BenchmarkOptions& options, const Registry& registry) {
  check_engine(options.engine);
  check_folder(options.out);
  const BenchmarkResult result = read_benchmark_result(file);
  const BenchmarkList list = read_benchmark_list(options.list);
  if (list.digest != result.list_digest) {
    throw InputError(options.list.string(), "a list with the digest " + list.digest,
                     fmt::format("that of {}, {} ({}, version {}); --list names it", file.string(),
                                 result.list_digest, result.list, result.list_version));
  }
  const YamlTree tree = parse_yaml("detectors: " + result.configuration, file.string());
  const BenchmarkEntry entry{result.entry, *tree.root.find("detectors"), file.string(), result.latency_class};
  std::vector<BenchmarkPart> parts = parts_of(list, result.quick);
  keep_a_tenth(parts);
  const auto planned = plan_entry(std::move(parts), entry, list, options.version, registry);
  const std::vector<BenchmarkRow> rows =
      make_rows(planned, options.out / result.entry, result.entry, options);
  if (rows.empty()) return 1;
  std::vector<std::string> lines;
  for (const BenchmarkRow& row : rows) {
    const auto before = std::ranges::find(result.rows, row.run, &BenchmarkRow::run);
    if (before == result.rows.end()) {
      lines.push_back(row.run + ": not in the result");
      continue;
    }
    for (std::string& line : differences(*before, row)) lines.push_back(std::move(line));
  }
  const std::string here = fmt::format("{} ({})", version(), commit());
  if (here != result.saccade) fmt::print("made with saccade {}, repeated with {}\n", result.saccade, here);
  for (const std::string& line : lines) fmt::print("{}\n", line);
  fmt::print("{} of {} runs repeated: {}\n", rows.size(), result.rows.size(),
             lines.empty() ? fmt::format("every figure within {}, and the same events", verify_tolerance)
                           : fmt::format("{} differences", lines.size()));
  return lines.empty() ? 0 : 3;
}

void write_benchmark_figures(const fs::path& run, const fs::path& file) {
  const Metrics metrics = read_metrics(run / "metrics.json");
  const auto truth = read_table<TruthRow>(run / "truth.csv");
  const auto detections = read_table<DetectionRow>(run / "detections.csv");
  Json json{{"events_digest", digest_of_events(run / metrics.events_file)}};
  for (const auto& [name, score] : metrics.detectors) {
    const auto reaction = reaction_ms(truth, found_at_chances(truth, detections, name, score.threshold));
    json["reaction_ms"][name] = reaction ? Json(*reaction) : Json(nullptr);
  }
  write_file(file, json.dump(1) + "\n");
}

}  // namespace saccade
