#include "apps/sweep/dataset_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "config/sections.h"
#include "config/yaml_reader.h"
#include "core/error.h"

namespace saccade {
namespace {

using Kind = YamlNode::Kind;

/// Keys of a sweep that the file has for all splits, and a split for itself.
constexpr std::array<std::string_view, 7> split_keys = {"scenario", "set",     "axes",       "except",
                                                        "only",     "samples", "sample_seed"};
/// Data sets have their events in a format of their own.
constexpr std::string_view events_key = "output.events";

void put(YamlNode& map, const std::string& key, const YamlNode& value) {
  const auto at = std::ranges::find(map.keys, key);
  if (at != map.keys.end()) {
    map.items[static_cast<std::size_t>(at - map.keys.begin())] = value;
    return;
  }
  map.keys.push_back(key);
  map.items.push_back(value);
}

/// What both say: the keys of two blocks, where both have one that of `own`; the items of two lists; of anything else `own`.
YamlNode merged(const YamlNode& common, const YamlNode& own) {
  YamlNode result = common;
  if (common.kind == Kind::map && own.kind == Kind::map) {
    for (std::size_t i = 0; i < own.keys.size(); ++i) put(result, own.keys[i], own.items[i]);
    return result;
  }
  if (common.kind != Kind::list || own.kind != Kind::list) return own;
  result.items.insert(result.items.end(), own.items.begin(), own.items.end());
  return result;
}

class DatasetReader {
 public:
  DatasetReader(const std::filesystem::path& path, const std::vector<std::string>& assignments)
      : tree_(read_yaml_file(path)), folder_(path.parent_path()), assignments_(assignments) {
    const YamlNode splits = take("splits");
    for (const std::string_view key : split_keys) {
      if (const YamlNode node = take(key); node.mark.line > 0) put(common_, std::string(key), node);
    }
    add_problems([&] {
      YamlReader reader(tree_, {"name"});
      describe(reader, file_);
      reader.finish();
    });
    read_splits(splits);
    if (!problems_.empty()) throw InputError(std::move(problems_));
  }

  [[nodiscard]] DatasetFile result() && { return std::move(file_); }

 private:
  YamlNode take(std::string_view key) {
    YamlNode& root = tree_.root;
    const auto at = std::ranges::find(root.keys, key);
    if (at == root.keys.end()) return {};
    const auto item = root.items.begin() + (at - root.keys.begin());
    YamlNode node = std::move(*item);
    root.items.erase(item);
    root.keys.erase(at);
    return node;
  }

  void complain(TextMark mark, const std::string& path, const std::string& value,
                const std::string& expectation) {
    problems_.push_back({tree_.place(mark, path), value, expectation});
  }

  /// Splits have keys in common: a problem of these is reported once.
  template <class Work>
  void add_problems(const Work& work) {
    try {
      work();
    } catch (const InputError& error) {
      for (const Problem& problem : error.problems()) {
        const auto same = [&](const Problem& known) { return known.text() == problem.text(); };
        if (std::ranges::none_of(problems_, same)) problems_.push_back(problem);
      }
    }
  }

  void read_splits(const YamlNode& splits) {
    if (splits.kind != Kind::map || splits.keys.empty()) {
      const TextMark mark{std::max(splits.mark.line, 1), splits.mark.column};
      complain(mark, "splits", splits.kind == Kind::map ? "no split" : splits.found(),
               "a block that has, for the name of each split, a block with axes");
      return;
    }
    for (std::size_t i = 0; i < splits.keys.size(); ++i) read_split(splits.keys[i], splits.items[i]);
  }

  void read_split(const std::string& name, const YamlNode& split) {
    const std::string path = "splits." + name;
    if (split.kind != Kind::map && split.kind != Kind::nothing) {
      complain(split.mark, path, split.found(),
               "a block with axes, or nothing where the file has them for all");
      return;
    }
    YamlTree sweep;
    sweep.file = tree_.file;
    sweep.root = common_;
    sweep.root.mark = split.mark;
    for (std::size_t i = 0; i < split.keys.size(); ++i) {
      const std::string& key = split.keys[i];
      if (std::ranges::find(split_keys, key) == split_keys.end()) {
        complain(split.items[i].mark, fmt::format("{}.{}", path, key), "no such key",
                 expectation_of({split_keys.begin(), split_keys.end()}));
        continue;
      }
      const YamlNode* common = common_.entry(key);
      put(sweep.root, key, common == nullptr ? split.items[i] : merged(*common, split.items[i]));
    }
    YamlNode text = YamlNode::of(Kind::scalar, split.mark);
    text.text = name;
    text.quoted = true;
    put(sweep.root, "name", text);
    add_problems([&] {
      SweepConfig config = read_sweep(std::move(sweep), folder_, assignments_);
      config.description = file_.name + ", split " + name;
      config.report.worst = 0;
      set_events(config);
      file_.splits.push_back(std::move(config));
    });
  }

  /// The run writes a format that is read back exactly, from which its events.npy is made.
  void set_events(SweepConfig& config) {
    const auto refuse = [&](const SweepSetting& setting) {
      if (setting.key != events_key && setting.key != "output") return;
      const YamlNode* value = setting.key == "output" ? setting.value.entry("events") : &setting.value;
      if (value != nullptr)
        problems_.push_back({setting.place, value->found(), "no output.events: a data set has events.npy"});
    };
    for (const SweepSetting& setting : config.set) refuse(setting);
    for (const SweepAxis& axis : config.axes)
      for (const SweepValue& value : axis.values)
        for (const SweepSetting& setting : value.settings) refuse(setting);
    YamlNode format = YamlNode::of(Kind::scalar);
    format.text = "npz";
    config.set.push_back({std::string(events_key), format, "the data set's own setting"});
  }

  YamlTree tree_;
  std::filesystem::path folder_;
  const std::vector<std::string>& assignments_;
  YamlNode common_ = YamlNode::of(Kind::map);
  DatasetFile file_;
  std::vector<Problem> problems_;
};

}  // namespace

void describe(FieldVisitor& v, DatasetFile& file) {
  describe_name(v, file.name, "name of the data set, and of its folder");
  v.text("description", file.description, "what the data are for, in a sentence");
  v.text("licence", file.licence, "licence of the data, as the card states it; without it: not stated");
}

DatasetFile read_dataset_file(const std::filesystem::path& path,
                              const std::vector<std::string>& assignments) {
  return DatasetReader(path, assignments).result();
}

}  // namespace saccade
