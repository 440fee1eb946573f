#include "apps/sweep/dataset_card.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <initializer_list>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string_view>

#include "core/error.h"
#include "evaluation/scoring/metrics.h"
#include "recording/array_file.h"
#include "recording/event_file.h"
#include "recording/file_digest.h"
#include "recording/output_file.h"
#include "recording/run_file_names.h"
#include "recording/run_files.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* events_file = "events.npy";
constexpr const char* labels_file = "labels.npz";
constexpr const char* run_json = "dataset.json";
constexpr double half_visible = 0.5;

/// Files of a run folder that a data set keeps as they are, where the run wrote them, and what they are.
constexpr std::array<std::pair<const char*, const char*>, 9> kept = {{
    {run_file::scenario, "the scenario with every default; `saccade run` makes the run again"},
    {run_file::truth,
     "true circle (px), visible share and centre (m, root frame) of the ball, each millisecond"},
    {run_file::truth_right, "the same in the right camera's image"},
    {run_file::target, "box around a target that is no sphere, px"},
    {run_file::eye, "true pose of the left camera in the root frame (m, unit quaternion)"},
    {run_file::joints, "measured joints, rad"},
    {run_file::imu, "inertial readings"},
    {run_file::ground_truth_hdf5, "ground truth of every pixel"},
    {run_file::ground_truth_npz, "ground truth of every pixel"},
}};
/// Those that the data set makes.
constexpr std::array<std::pair<const char*, const char*>, 2> made = {{
    {events_file, "events: records of x, y (px), t (us), p (true: brighter), and with two cameras camera"},
    {labels_file, "the circles as arrays; with `output.labels` cause and object of each event"},
}};

Json json_in(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw RunError(file.string() + ": cannot be read");
  try {
    return Json::parse(in);
  } catch (const Json::exception& error) {
    throw RunError(file.string() + ": found no JSON: " + error.what());
  }
}

void convert_events(const fs::path& from, const fs::path& to, ImageSize image, int cameras) {
  const auto reader = open_event_file(from);
  const auto writer = create_event_file(to, image, cameras);
  constexpr std::size_t chunk = 1 << 16;
  for (std::vector<Event> events; reader->read(events, chunk) > 0; events.clear()) writer->write(events);
  writer->commit();
}

/// Numbers for words: those of the words that it starts with are the same in every run.
class Numbers {
 public:
  explicit Numbers(std::initializer_list<const char*> words) {
    for (const char* word : words) of(word);
  }
  std::uint8_t of(const std::string& word) {
    const auto [at, is_new] = numbers_.try_emplace(word, static_cast<std::uint8_t>(words_.size()));
    if (is_new) words_.push_back(word);
    return at->second;
  }
  [[nodiscard]] const std::vector<std::string>& words() const { return words_; }

 private:
  std::map<std::string, std::uint8_t> numbers_;
  std::vector<std::string> words_;
};

/// Number of rows, and of those with at least half of the target visible.
struct Instants {
  std::int64_t all = 0;
  std::int64_t with_target = 0;
};

/// truth.csv as arrays, below `eye`; t_us once.
Instants put_truth(ArrayFile& file, const std::string& eye, const fs::path& table) {
  std::vector<std::int64_t> t_us;
  std::vector<double> circles;
  std::vector<double> visible;
  std::vector<double> centres;
  Instants instants;
  TableReader<TruthRow> reader(table);
  while (const auto row = reader.next()) {
    t_us.push_back(row->t_us);
    circles.insert(circles.end(), {row->circle.x_px, row->circle.y_px, row->circle.r_px});
    visible.push_back(row->visible);
    centres.insert(centres.end(), {row->position_m.x(), row->position_m.y(), row->position_m.z()});
    ++instants.all;
    if (row->visible >= half_visible) ++instants.with_target;
  }
  const auto put = [&]<class T>(const std::string& name, ArrayType type,
                                const std::vector<std::size_t>& shape, const std::vector<T>& values) {
    file.append(file.add(name, type, shape), std::span<const T>(values));
  };
  if (eye == "left") {
    put("t_us", ArrayType::i64, {}, t_us);
    put("target_m", ArrayType::f64, {3}, centres);
  }
  put(eye + "/circle_px", ArrayType::f64, {3}, circles);
  put(eye + "/visible", ArrayType::f64, {}, visible);
  return instants;
}

void put_event_labels(ArrayFile& file, const std::string& eye, const fs::path& table, Numbers& causes,
                      Numbers& objects) {
  std::vector<std::uint8_t> cause;
  std::vector<std::uint8_t> object;
  TableReader<LabelRow> reader(table);
  while (const auto row = reader.next()) {
    cause.push_back(causes.of(row->cause));
    object.push_back(objects.of(row->object));
  }
  file.append(file.add(eye + "/cause", ArrayType::u8, {}), std::span<const std::uint8_t>(cause));
  file.append(file.add(eye + "/object", ArrayType::u8, {}), std::span<const std::uint8_t>(object));
}

Instants make_labels(const fs::path& part, const fs::path& to) {
  const auto file = create_array_file(to);
  const Instants instants = put_truth(*file, "left", part / run_file::truth);
  if (fs::exists(part / run_file::truth_right)) put_truth(*file, "right", part / run_file::truth_right);
  Numbers causes{"signal", "leak", "shot", "hot"};
  Numbers objects{"background", "ball", "hand", "arm", "distractor"};
  const bool has_labels = fs::exists(part / run_file::labels);
  if (has_labels) put_event_labels(*file, "left", part / run_file::labels, causes, objects);
  if (fs::exists(part / run_file::labels_right))
    put_event_labels(*file, "right", part / run_file::labels_right, causes, objects);
  if (has_labels) {
    file->put("causes", causes.words());
    file->put("objects", objects.words());
  }
  file->commit();
  return instants;
}

Json json_of(const DatasetRun& run) {
  Json json{{"seed", run.seed},
            {"duration_s", run.duration_s},
            {"size_px", {run.image.width, run.image.height}},
            {"cameras", run.cameras},
            {"events", run.events},
            {"dropped", run.dropped},
            {"instants", run.instants},
            {"with_target", run.with_target}};
  Json files = Json::array();
  for (const DatasetItem& item : run.files)
    files.push_back({{"name", item.name}, {"bytes", item.bytes}, {"digest", item.digest}});
  json["files"] = std::move(files);
  return json;
}

DatasetRun run_of(const Json& json) {
  DatasetRun run;
  json.at("seed").get_to(run.seed);
  json.at("duration_s").get_to(run.duration_s);
  run.image = {json.at("size_px").at(0).get<int>(), json.at("size_px").at(1).get<int>()};
  json.at("cameras").get_to(run.cameras);
  json.at("events").get_to(run.events);
  json.at("dropped").get_to(run.dropped);
  json.at("instants").get_to(run.instants);
  json.at("with_target").get_to(run.with_target);
  for (const Json& item : json.at("files")) {
    run.files.push_back({item.at("name").get<std::string>(), item.at("bytes").get<std::int64_t>(),
                         item.at("digest").get<std::string>()});
  }
  return run;
}

/// Sums over the runs of a split.
struct SplitSums {
  std::int64_t runs = 0;
  double duration_s = 0.0;
  std::int64_t events = 0, dropped = 0, instants = 0, with_target = 0, bytes = 0;
  std::set<std::int64_t> seeds;
  std::set<std::string> sizes;
};

SplitSums sums_of(const DatasetCard& card, const std::string& split) {
  SplitSums sums;
  for (const DatasetRun& run : card.runs) {
    if (run.split != split) continue;
    ++sums.runs;
    sums.duration_s += run.duration_s;
    sums.events += run.events;
    sums.dropped += run.dropped;
    sums.instants += run.instants;
    sums.with_target += run.with_target;
    sums.bytes += run.bytes();
    sums.seeds.insert(run.seed);
    sums.sizes.insert(fmt::format("{}x{}", run.image.width, run.image.height));
  }
  return sums;
}

double share(std::int64_t part, std::int64_t of) {
  return of > 0 ? static_cast<double>(part) / static_cast<double>(of) : 0.0;
}

/// 1 to 3, 7
std::string ranges_text(const std::set<std::int64_t>& numbers) {
  std::string text;
  for (auto at = numbers.begin(); at != numbers.end();) {
    const std::int64_t first = *at;
    std::int64_t last = first;
    while (++at != numbers.end() && *at == last + 1) last = *at;
    text += (text.empty() ? "" : ", ") + std::to_string(first);
    if (last > first) text += (last > first + 1 ? " to " : ", ") + std::to_string(last);
  }
  return text;
}

/// Values of each axis but the seed, with the number of runs.
std::string values_text(const DatasetCard& card, const std::string& split) {
  std::vector<std::string> axes;
  std::map<std::string, std::map<std::string, int>> counts;
  for (const DatasetRun& run : card.runs) {
    if (run.split != split) continue;
    for (const auto& [axis, value] : run.values) {
      if (axis == "seed") continue;
      if (std::ranges::find(axes, axis) == axes.end()) axes.push_back(axis);
      ++counts[axis][value];
    }
  }
  constexpr std::size_t most_values = 12;
  std::string text;
  for (const std::string& axis : axes) {
    text += (text.empty() ? "" : "; ") + fmt::format("`{}`: ", axis);
    if (counts[axis].size() > most_values) {
      text += fmt::format("{} values", counts[axis].size());
      continue;
    }
    std::string values;
    for (const auto& [value, count] : counts[axis])
      values += (values.empty() ? "" : ", ") + fmt::format("{} ({})", value, count);
    text += values;
  }
  return text.empty() ? "–" : text;
}

std::string in_cell(std::string text) {
  for (std::size_t at = 0; (at = text.find('|', at)) != std::string::npos; at += 2) text.insert(at, "\\");
  return text;
}

std::string markdown_of(const DatasetCard& card) {
  std::string text = "# " + card.name + "\n\n";
  if (!card.description.empty()) text += card.description + "\n\n";
  const auto row = [&](const char* what, const std::string& value) {
    text += fmt::format("|{}|{}|\n", what, in_cell(value));
  };
  text += "|||\n|---|---|\n";
  row("licence", card.licence.empty() ? "not stated" : card.licence);
  row("made by", card.program);
  row("digest", digest_of(card));
  text +=
      "\n`saccade dataset check` compares every file with its digest in card.json; `saccade.Dataset` reads "
      "the data in Python.\n\n## Splits\n\n"
      "|split|runs|seconds|events|MB|image|seeds|ball visible, share of time|events dropped by the bus|"
      "further values (runs)|\n|---|---:|---:|---:|---:|---|---|---:|---:|---|\n";
  for (const std::string& split : splits_of(card)) {
    const SplitSums sums = sums_of(card, split);
    std::string sizes;
    for (const std::string& size : sums.sizes) sizes += (sizes.empty() ? "" : ", ") + size;
    text += fmt::format("|{}|{}|{:.1f}|{}|{:.1f}|{}|{}|{:.3f}|{:.2f} %|{}|\n", split, sums.runs,
                        sums.duration_s, sums.events, static_cast<double>(sums.bytes) * 1e-6, sizes,
                        ranges_text(sums.seeds), share(sums.with_target, sums.instants),
                        100.0 * share(sums.dropped, sums.events + sums.dropped),
                        in_cell(values_text(card, split)));
  }
  std::set<std::string> names;
  for (const DatasetRun& run : card.runs)
    for (const DatasetItem& item : run.files) names.insert(item.name);
  text += "\n## Files of a run\n\nEach run is a folder `SPLIT/runs/ID`.\n\n|file|contents|\n|---|---|\n";
  const auto list = [&](const auto& files) {
    for (const auto& [name, what] : files)
      if (names.contains(name)) text += fmt::format("|`{}`|{}|\n", name, what);
  };
  list(made);
  list(kept);
  text += "\n## Known limits\n\n";
  for (const std::string& limit : card.limits) text += "- " + limit + "\n";
  return text;
}

}  // namespace

std::int64_t DatasetRun::bytes() const {
  std::int64_t sum = 0;
  for (const DatasetItem& item : files) sum += item.bytes;
  return sum;
}

std::string digest_of(const DatasetCard& card) {
  std::string text;
  for (const DatasetRun& run : card.runs) {
    text += fmt::format("{} {}\n", run.split, run.seed);
    for (const DatasetItem& item : run.files)
      text += fmt::format("{} {} {}\n", item.name, item.bytes, item.digest);
  }
  return digest(text);
}

std::vector<std::string> splits_of(const DatasetCard& card) {
  std::vector<std::string> splits;
  for (const DatasetRun& run : card.runs)
    if (std::ranges::find(splits, run.split) == splits.end()) splits.push_back(run.split);
  return splits;
}

std::string split_text(const DatasetCard& card, const std::string& split) {
  const SplitSums sums = sums_of(card, split);
  return fmt::format("{}: {} runs, {:.1f} s, {:.2f} million events, {:.1f} MB", split, sums.runs,
                     sums.duration_s, static_cast<double>(sums.events) * 1e-6,
                     static_cast<double>(sums.bytes) * 1e-6);
}

void write_dataset_card(const fs::path& folder, const DatasetCard& card) {
  Json json{{"schema", 1},
            {"name", card.name},
            {"description", card.description},
            {"licence", card.licence.empty() ? Json(nullptr) : Json(card.licence)},
            {"program", card.program},
            {"digest", digest_of(card)},
            {"limits", card.limits}};
  Json splits = Json::object();
  for (const std::string& split : splits_of(card)) {
    const SplitSums sums = sums_of(card, split);
    splits[split] = {{"runs", sums.runs},     {"duration_s", sums.duration_s},
                     {"events", sums.events}, {"dropped", sums.dropped},
                     {"bytes", sums.bytes},   {"with_target_share", share(sums.with_target, sums.instants)}};
  }
  json["splits"] = std::move(splits);
  Json runs = Json::array();
  for (const DatasetRun& run : card.runs) {
    Json values = Json::object();
    for (const auto& [axis, value] : run.values) values[axis] = value;
    Json entry{{"split", run.split}, {"folder", run.folder}, {"values", std::move(values)}};
    entry.update(json_of(run));
    runs.push_back(std::move(entry));
  }
  json["runs"] = std::move(runs);
  write_file(folder / "card.md", markdown_of(card));
  write_file(folder / dataset_card_json, json.dump(1) + "\n");
}

ReadDatasetCard read_dataset_card(const fs::path& folder) {
  const fs::path file = folder / dataset_card_json;
  std::error_code ignored;
  if (!fs::is_directory(folder, ignored))
    throw InputError(folder.string(), "no folder", "the folder of a data set");
  if (!fs::is_regular_file(file, ignored)) {
    const bool begun = fs::exists(folder / "plan.json", ignored);
    throw InputError(folder.string(), begun ? "a data set without all of its runs" : "no card.json",
                     begun ? "a whole one; the command that began it goes on" : "the folder of a data set");
  }
  std::ifstream in(file, std::ios::binary);
  ReadDatasetCard read;
  try {
    const Json json = Json::parse(in);
    if (json.at("schema").get<int>() != 1)
      throw InputError(file.string(), "schema " + json.at("schema").dump(), "1");
    DatasetCard& card = read.card;
    json.at("name").get_to(card.name);
    json.at("description").get_to(card.description);
    if (!json.at("licence").is_null()) json.at("licence").get_to(card.licence);
    json.at("program").get_to(card.program);
    json.at("digest").get_to(read.digest);
    json.at("limits").get_to(card.limits);
    for (const Json& entry : json.at("runs")) {
      DatasetRun run = run_of(entry);
      entry.at("split").get_to(run.split);
      entry.at("folder").get_to(run.folder);
      for (const auto& [axis, value] : entry.at("values").items())
        run.values.emplace_back(axis, value.get<std::string>());
      card.runs.push_back(std::move(run));
    }
  } catch (const Json::exception& error) {
    throw InputError(file.string(), error.what(), "the card of a data set, as saccade wrote it");
  }
  return read;
}

std::string keep_dataset_run(const fs::path& part, const fs::path& folder) {
  const Metrics metrics = read_metrics(part / run_file::metrics);
  DatasetRun run;
  run.seed = metrics.seed.value_or(0);
  run.duration_s = metrics.duration_s;
  run.image = metrics.image;
  run.cameras = metrics.right_eye ? 2 : 1;
  run.events = metrics.event_count;
  run.dropped = metrics.events_dropped.value_or(0);
  convert_events(part / metrics.events_file, folder / events_file, run.image, run.cameras);
  const Instants instants = make_labels(part, folder / labels_file);
  run.instants = instants.all;
  run.with_target = instants.with_target;
  for (const auto& [name, what] : kept)
    if (fs::exists(part / name)) fs::rename(part / name, folder / name);
  const auto add = [&](const char* name) {
    const fs::path file = folder / name;
    if (!fs::exists(file)) return;
    run.files.push_back({name, static_cast<std::int64_t>(fs::file_size(file)), digest_of_file(file)});
  };
  for (const auto& [name, what] : made) add(name);
  for (const auto& [name, what] : kept) add(name);
  write_file(folder / run_json, json_of(run).dump(1) + "\n");
  return events_file;
}

DatasetRun read_dataset_run(const fs::path& folder) {
  try {
    return run_of(json_in(folder / run_json));
  } catch (const Json::exception& error) {
    throw RunError((folder / run_json).string() + ": " + error.what());
  }
}

}  // namespace saccade
