#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "core/event.h"

namespace saccade {

/// A file of a data set, with its place below the data set's folder.
struct DatasetItem {
  std::string name;
  std::int64_t bytes = 0;
  std::string digest;  ///< digest_of_file()
};

/// One run of a data set.
struct DatasetRun {
  std::string split;
  std::string folder;  ///< below the data set's: "train/runs/ID"
  std::int64_t seed = 0;
  std::vector<std::pair<std::string, std::string>> values;  ///< of each axis of its split
  double duration_s = 0.0;
  ImageSize image;
  int cameras = 1;
  std::int64_t events = 0;
  std::int64_t dropped = 0;   ///< by the bus of the left camera
  std::int64_t instants = 0;  ///< rows of truth.csv
  std::int64_t with_target =
      0;  ///< of these, with at least half of the ball's disc (or of the target) visible
  std::vector<DatasetItem> files;

  [[nodiscard]] std::int64_t bytes() const;
};

/// What card.json and card.md of a data set state.
struct DatasetCard {
  std::string name;
  std::string description;
  std::string licence;  ///< empty: not stated
  std::string program;  ///< that made it: version, commit, digest, MuJoCo
  std::vector<std::string> limits;
  std::vector<DatasetRun> runs;  ///< in the order of the splits
};

/// A digest of the names, sizes and digests of all files in their order, without the ids of the runs: data sets of the same
/// data have the same one, whichever program made them.
[[nodiscard]] std::string digest_of(const DatasetCard& card);

inline constexpr const char* dataset_card_json = "card.json";

/// Writes card.json and card.md into the folder. The same data set gives the same bytes.
void write_dataset_card(const std::filesystem::path& folder, const DatasetCard& card);

/// Reads card.json in the folder. Throws InputError for a folder without one and for a file that is none.
struct ReadDatasetCard {
  DatasetCard card;
  std::string digest;  ///< that the file states
};
[[nodiscard]] ReadDatasetCard read_dataset_card(const std::filesystem::path& folder);

/// The line of a split on standard output: runs, seconds, events, megabytes.
[[nodiscard]] std::string split_text(const DatasetCard& card, const std::string& split);
/// Names of the splits in their order.
[[nodiscard]] std::vector<std::string> splits_of(const DatasetCard& card);

/// Makes the files that a run of a data set has of those that the run wrote into `part`, and moves them into `folder`, which
/// has the run's scenario.yaml; then dataset.json, which read_dataset_run() reads. Returns the name of the file of events.
/// Throws RunError, DiskFull.
std::string keep_dataset_run(const std::filesystem::path& part, const std::filesystem::path& folder);
[[nodiscard]] DatasetRun read_dataset_run(const std::filesystem::path& folder);

}  // namespace saccade
