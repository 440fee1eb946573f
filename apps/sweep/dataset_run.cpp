#include "apps/sweep/dataset_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "apps/sweep/dataset_card.h"
#include "apps/sweep/dataset_file.h"
#include "apps/sweep/sweep_coordinator.h"
#include "apps/sweep/sweep_folder.h"
#include "apps/sweep/sweep_plan.h"
#include "apps/sweep/sweep_run.h"
#include "core/error.h"
#include "recording/file_digest.h"
#include "recording/file_lock.h"
#include "recording/output_file.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// Names of splits have no dot, so none of them is the name of these.
constexpr const char* plan_json = "plan.json";
constexpr const char* lock_file = "dataset.lock";
constexpr const char* copy_of_file = "dataset.yaml";
constexpr std::size_t most_lines = 20;

struct PlannedDataset {
  DatasetFile file;
  std::vector<SweepPlan> splits;
};

/// Two splits must not share a run: what is learned in one would be judged on itself in the other.
void add_shared_runs(const std::vector<SweepPlan>& splits, const fs::path& file,
                     std::vector<Problem>& problems) {
  std::map<std::string, std::string> split_of;
  for (const SweepPlan& split : splits) {
    for (const PlannedRun& run : split.runs) {
      const auto [at, is_new] = split_of.try_emplace(run.id, split.config.name);
      if (is_new || at->second == split.config.name) continue;
      problems.push_back({file.string() + ": splits." + split.config.name,
                          fmt::format("the run of seed {} that {} has too", run.seed, at->second),
                          "splits without a common run"});
      break;
    }
  }
}

/// Reports bad options and everything that is wrong in the file together.
PlannedDataset plan_dataset(const DatasetOptions& options, const Registry& registry) {
  PlannedDataset planned;
  std::vector<Problem> problems;
  const auto collect = [&](const auto& work) {
    try {
      work();
    } catch (const InputError& error) {
      for (const Problem& problem : error.problems()) {
        const auto same = [&](const Problem& known) { return known.text() == problem.text(); };
        if (std::ranges::none_of(problems, same)) problems.push_back(problem);
      }
    }
  };
  collect([&] { check_engine(options.engine); });
  collect([&] { planned.file = read_dataset_file(options.file, options.assignments); });
  for (const SweepConfig& split : planned.file.splits)
    collect([&] { planned.splits.push_back(plan_sweep(split, options.program, registry)); });
  add_shared_runs(planned.splits, options.file, problems);
  if (!problems.empty()) throw InputError(std::move(problems));
  return planned;
}

std::string digest_of_plan(const PlannedDataset& planned) {
  std::string text;
  for (const SweepPlan& split : planned.splits) {
    text += split.config.name + "\n";
    for (const PlannedRun& run : split.runs) text += run.id + "\n";
  }
  return digest(text);
}

/// What a folder belongs to.
struct PlanMark {
  std::string name;
  std::string file;  ///< digest of file and --set
  std::string program;
  std::string plan;  ///< digest of the runs
};

PlanMark read_mark(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  try {
    const Json json = Json::parse(in);
    return {json.at("name").get<std::string>(), json.at("file").get<std::string>(),
            json.at("program").get<std::string>(), json.at("plan").get<std::string>()};
  } catch (const Json::exception& error) {
    throw InputError(path.string(), error.what(), "the plan of a data set, as saccade wrote it");
  }
}

void write_mark(const fs::path& path, const PlanMark& mark) {
  const Json json{{"name", mark.name}, {"file", mark.file}, {"program", mark.program}, {"plan", mark.plan}};
  write_file(path, json.dump(1) + "\n");
}

PlanMark mark_of(const DatasetOptions& options, const PlannedDataset& planned) {
  std::string text = text_of_file(options.file);
  for (const std::string& assignment : options.assignments) text += "\n" + assignment;
  return {planned.file.name, digest(text), options.program, digest_of_plan(planned)};
}

/// Throws InputError for a folder that does not belong to the plan.
void check_folder(const fs::path& out, const PlanMark& mark) {
  std::error_code ignored;
  if (!fs::exists(out, ignored)) return;
  if (!fs::is_directory(out, ignored)) throw InputError(out.string(), "a file", "a folder for the data set");
  if (!fs::exists(out / plan_json, ignored)) {
    for (const auto& entry : fs::directory_iterator(out)) {
      if (entry.path().filename() == lock_file) continue;
      throw InputError(out.string(), "a folder with other files in it",
                       "a new folder, or that of this data set");
    }
    return;
  }
  const PlanMark before = read_mark(out / plan_json);
  if (before.plan == mark.plan) return;
  if (before.name != mark.name || before.file != mark.file) {
    throw InputError(out.string(), fmt::format("the data set {} of another file or --set", before.name),
                     fmt::format("a new folder for {}, or the file that the folder's {} is a copy of",
                                 mark.name, copy_of_file));
  }
  if (before.program != mark.program) {
    throw InputError(out.string(), "a data set of the program " + before.program,
                     "a new folder, or that program; this is " + mark.program);
  }
  throw InputError(out.string(), "a data set whose runs read a file that has changed since",
                   "a new folder, or the file as it was");
}

/// What every simulated data set lacks.
std::vector<std::string> limits_of(const DatasetCard& card) {
  std::vector<std::string> limits = {
      "Simulated: no shadows, reflections, defocus or motion blur; contacts between ball, hand and board are "
      "not "
      "simulated.",
      "Circles are those of the true sphere, also where something hides it; `visible` is the share of its "
      "disc that "
      "is seen."};
  std::int64_t dropped = 0;
  std::int64_t without = 0;
  std::map<std::int64_t, std::set<std::string>> splits_of_seed;
  for (const DatasetRun& run : card.runs) {
    dropped += run.dropped > 0 ? 1 : 0;
    without += run.with_target == 0 ? 1 : 0;
    splits_of_seed[run.seed].insert(run.split);
  }
  const auto count = [](std::int64_t runs, const char* what) {
    return fmt::format("In {} {} {}", runs, runs == 1 ? "run" : "runs", what);
  };
  if (dropped > 0) limits.push_back(count(dropped, "the bus of the camera dropped events."));
  if (without > 0) limits.push_back(count(without, "the ball is never visible by half."));
  std::int64_t shared = 0;
  bool judging = false;
  for (const auto& [seed, splits] : splits_of_seed) {
    shared += splits.size() > 1 ? 1 : 0;
    judging = judging || (seed >= 2000 && seed < 2200);
  }
  if (shared > 0)
    limits.push_back(fmt::format("{} {} in more than one split, with other values of the scenario.", shared,
                                 shared == 1 ? "seed is" : "seeds are"));
  if (judging)
    limits.push_back(
        "It has seeds from 2000 to 2199, on which random worlds judge detectors: nothing may be chosen on "
        "these.");
  return limits;
}

/// Adds the runs of a split in the order of the plan, each once.
void add_runs(const SweepPlan& plan, const SweepFolder& sweep, DatasetCard& card) {
  std::set<std::string> seen;
  for (const PlannedRun& planned : plan.runs) {
    if (!seen.insert(planned.id).second) continue;
    DatasetRun run = read_dataset_run(sweep.run(planned.id));
    run.split = plan.config.name;
    run.folder = run.split + "/runs/" + planned.id;
    for (std::size_t a = 0; a < plan.config.axes.size(); ++a)
      run.values.emplace_back(plan.config.axes[a].key, plan.config.axes[a].values[planned.values[a]].text);
    card.runs.push_back(std::move(run));
  }
}

/// What is in the folder of a split's runs and not on the card; the files of the engine are neither.
std::vector<std::string> strangers(const fs::path& folder, const DatasetCard& card) {
  static const std::set<std::string> of_engine = {"metrics.json", "dataset.json", "log.txt"};
  std::set<std::string> known;
  for (const DatasetRun& run : card.runs)
    for (const DatasetItem& item : run.files) known.insert(run.folder + "/" + item.name);
  std::vector<std::string> found;
  for (const std::string& split : splits_of(card)) {
    std::error_code ignored;
    for (fs::recursive_directory_iterator at(folder / split / "runs", ignored), end; at != end; ++at) {
      if (at->is_directory()) continue;
      const std::string place = fs::relative(at->path(), folder).generic_string();
      if (!known.contains(place) && !of_engine.contains(at->path().filename().string()))
        found.push_back(place);
    }
  }
  std::ranges::sort(found);
  return found;
}

}  // namespace

int make_dataset(const DatasetOptions& options, const Registry& registry) {
  const PlannedDataset planned = plan_dataset(options, registry);
  const fs::path out = options.out.empty() ? fs::path("datasets") / planned.file.name : options.out;
  const PlanMark mark = mark_of(options, planned);
  check_folder(out, mark);
  std::error_code error;
  fs::create_directories(out, error);
  if (error) throw RunError(out.string() + ": cannot make the folder: " + error.message());
  const FileLock lock(out / lock_file);
  if (!lock.held())
    throw InputError(out.string(), "a data set at work in it", "another folder, or wait for its end");
  check_folder(out, mark);  // another process may have begun one in between
  if (!fs::exists(out / plan_json)) write_mark(out / plan_json, mark);
  write_file(out / copy_of_file, text_of_file(options.file));

  DatasetCard card{.name = planned.file.name,
                   .description = planned.file.description,
                   .licence = planned.file.licence,
                   .program = mark.program,
                   .limits = {},
                   .runs = {}};
  std::int64_t failed = 0;
  for (const SweepPlan& plan : planned.splits) {
    fmt::print(stderr, "{}: ", plan.config.name);
    make_sweep(plan, out / plan.config.name, options.engine, options.retry, {"--dataset"},
               [&](SweepCoordinator& coordinator, const SweepFolder& sweep) {
                 const std::int64_t bad = coordinator.store().count("failed");
                 failed += bad;
                 if (bad == 0) add_runs(plan, sweep, card);
               });
  }
  if (failed > 0) {
    fmt::print(
        stderr,
        "saccade: {}: {} runs failed, so there is no card; each has a failure.txt in SPLIT/runs/ID, and "
        "--retry makes them again\n",
        out.string(), failed);
    return 1;
  }
  card.limits = limits_of(card);
  write_dataset_card(out, card);
  for (const std::string& split : splits_of(card)) fmt::print("{}\n", split_text(card, split));
  fmt::print("digest {}\n{}\n", digest_of(card), (out / "card.md").string());
  return 0;
}

int check_dataset(const fs::path& folder) {
  const ReadDatasetCard read = read_dataset_card(folder);
  const DatasetCard& card = read.card;
  std::vector<std::string> lines;
  if (digest_of(card) != read.digest)
    lines.push_back(fmt::format("{}: the digest of what it lists is {}, it states {}",
                                (folder / dataset_card_json).string(), digest_of(card), read.digest));
  std::int64_t files = 0;
  std::int64_t bytes = 0;
  for (const DatasetRun& run : card.runs) {
    for (const DatasetItem& item : run.files) {
      ++files;
      bytes += item.bytes;
      const fs::path file = folder / run.folder / item.name;
      std::error_code error;
      const std::uintmax_t size = fs::file_size(file, error);
      if (error) {
        lines.push_back(file.string() + ": missing");
      } else if (size != static_cast<std::uintmax_t>(item.bytes)) {
        lines.push_back(fmt::format("{}: {} bytes, on the card {}", file.string(), size, item.bytes));
      } else if (const std::string found = digest_of_file(file); found != item.digest) {
        lines.push_back(fmt::format("{}: digest {}, on the card {}", file.string(), found, item.digest));
      }
    }
  }
  for (const std::string& stranger : strangers(folder, card))
    lines.push_back((folder / stranger).string() + ": not on the card");
  for (std::size_t i = 0; i < std::min(lines.size(), most_lines); ++i) fmt::print("{}\n", lines[i]);
  if (lines.size() > most_lines) fmt::print("... and {} more\n", lines.size() - most_lines);
  fmt::print(
      "{}: {} runs, {} files, {:.1f} MB: {}\n", card.name, card.runs.size(), files,
      static_cast<double>(bytes) * 1e-6,
      lines.empty()
          ? fmt::format("as on the card, digest {}", read.digest)
          : fmt::format("{} differences; without the folder of a run, `saccade dataset` makes it again",
                        lines.size()));
  return lines.empty() ? 0 : 3;
}

}  // namespace saccade
