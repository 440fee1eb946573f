#include "apps/sweep/run_sets.h"

#include <algorithm>
#include <fstream>
#include <iterator>

#include "apps/sweep/metrics_numbers.h"
#include "apps/sweep/sweep_folder.h"
#include "apps/sweep/sweep_store.h"
#include "core/error.h"
#include "recording/run_file_names.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;

fs::path figures_of(const fs::path& run) {
  const fs::path figures = run / run_file::figures_json;
  return fs::exists(figures) ? figures : run / run_file::metrics;
}

bool is_run(const fs::path& folder) {
  std::error_code ignored;
  return fs::exists(folder / run_file::metrics, ignored) ||
         fs::exists(folder / run_file::figures_json, ignored);
}

/// A folder in which a run was started.
bool is_started_run(const fs::path& folder) {
  std::error_code ignored;
  const auto holds = [&](const char* name) { return fs::exists(folder / name, ignored); };
  return is_run(folder) || holds(run_file::scenario) || holds(run_file::detectors) || holds(run_file::robot);
}

void add_once(std::vector<std::string>& list, const std::string& text) {
  if (!text.empty() && std::ranges::find(list, text) == list.end()) list.push_back(text);
}

MetricsNumbers numbers_of(const fs::path& run) {
  const fs::path file = figures_of(run);
  std::ifstream in(file, std::ios::binary);
  return metrics_numbers(std::string{std::istreambuf_iterator<char>(in), {}}, file.string());
}

/// Adds a run with a result, unless one of the same label, configuration and seed is there.
void add_run(RunSet& set, const std::string& label, const std::string& seed, const MetricsNumbers& numbers,
             const fs::path& run) {
  if (numbers.interrupted) {
    ++set.failed;
    return;
  }
  ResolvedKeys keys = read_resolved_keys(run);
  if (const auto version = keys.find("version"); version != keys.end()) {
    add_once(set.versions, version->second);
    keys.erase(version);
  }
  const auto same = [&](const SeedRuns& group) { return group.label == label && group.keys == keys; };
  auto group = std::ranges::find_if(set.groups, same);
  if (group == set.groups.end())
    group = set.groups.insert(group, {.label = label, .keys = keys, .seeds = {}, .figures = {}});
  if (std::ranges::find(group->seeds, seed) != group->seeds.end()) return;
  const std::size_t earlier = group->seeds.size();
  group->seeds.push_back(seed);
  for (const auto& [name, value] : numbers.metrics) {
    auto& values = group->figures[name];
    values.resize(earlier);
    values.push_back(value);
  }
  for (auto& [name, values] : group->figures) values.resize(group->seeds.size());
  ++set.runs;
}

/// `beside`: other runs are in the same set. A run without seed, such as a recording's, then has a label of its own.
void add_run_folder(RunSet& set, const fs::path& run, bool beside) {
  if (!is_run(run)) {
    ++set.failed;
    return;
  }
  const MetricsNumbers numbers = numbers_of(run);
  std::string label = numbers.scenario;
  if (!numbers.settings.empty()) label += " with " + numbers.settings;
  if (beside && numbers.seed.empty()) label += " in " + run.filename().string();
  add_run(set, label, numbers.seed, numbers, run);
}

void add_sweep(RunSet& set, const SweepFolder& folder) {
  const SweepTable table = SweepStore(folder).table();
  add_once(set.versions, table.version);
  for (const SweepRow& row : table.rows) {
    if (row.status != "done" || !is_run(folder.run(row.id))) {
      ++set.failed;
      continue;
    }
    std::string label;
    std::string seed;
    for (std::size_t i = 0; i < table.axes.size(); ++i) {
      if (table.axes[i] == "seed") {
        seed = row.values[i];
      } else {
        label += (label.empty() ? "" : ", ") + table.axes[i] + "=" + row.values[i];
      }
    }
    const fs::path run = folder.run(row.id);
    add_run(set, label.empty() ? table.name : label, seed, numbers_of(run), run);
  }
}

/// Groups of one label have edited copies of one scenario: their labels get what differs.
void make_labels_unique(std::vector<SeedRuns>& groups) {
  const std::vector<SeedRuns> before = groups;
  for (std::size_t i = 0; i < groups.size(); ++i) {
    const auto first = std::ranges::find(before, before[i].label, &SeedRuns::label);
    const bool is_first = first == before.begin() + static_cast<std::ptrdiff_t>(i);
    if (!is_first) groups[i].label += " with " + difference_text(first->keys, before[i].keys);
  }
  std::ranges::stable_sort(groups, {}, &SeedRuns::label);
}

}  // namespace

RunSet read_run_set(const fs::path& path) {
  RunSet set{.path = path, .versions = {}, .groups = {}};
  const SweepFolder sweep(path);
  std::error_code ignored;
  if (fs::exists(sweep.table(), ignored)) {
    add_sweep(set, sweep);
  } else if (is_started_run(path)) {
    add_run_folder(set, path, false);
  } else if (fs::is_directory(path, ignored)) {
    std::vector<fs::path> runs;
    for (const auto& entry : fs::directory_iterator(path)) {
      if (is_started_run(entry.path())) runs.push_back(entry.path());
    }
    std::ranges::sort(runs);
    for (const fs::path& run : runs) add_run_folder(set, run, true);
  }
  if (set.runs + set.failed == 0) {
    throw InputError(path.string(), fs::exists(path, ignored) ? "no run" : "nothing",
                     "a run folder, a folder of run folders, or the folder of a sweep");
  }
  make_labels_unique(set.groups);
  return set;
}

}  // namespace saccade
