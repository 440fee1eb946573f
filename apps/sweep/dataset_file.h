#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "apps/sweep/sweep_config.h"

namespace saccade {

/// A data set as its file describes it: splits, each of which is a sweep whose runs are kept.
///
///     name: balls
///     licence: CC-BY-4.0
///     scenario: random_world                # scenario, set, axes, except and only: of every split
///     set: {detectors: {}, run.duration_s: 2, output.labels: true}
///     splits:
///       train: {axes: {seed: {seeds: 40, first: 100000}}}
///       test: {set: {emulator.preset: davis346}, axes: {seed: {seeds: 10, first: 1000}}}
struct DatasetFile {
  std::string name;
  std::string description;
  std::string licence;              ///< of the data, as its card states it; empty: not stated
  std::vector<SweepConfig> splits;  ///< the name of each is that of the split
};

/// Keys with a value of their own: name, description, licence.
void describe(FieldVisitor& v, DatasetFile& file);

/// Reads the file of a data set; `assignments` are the `key=value` of --set, for every split. Scenarios are not read. Throws
/// InputError with everything that is wrong.
[[nodiscard]] DatasetFile read_dataset_file(const std::filesystem::path& path,
                                            const std::vector<std::string>& assignments);

}  // namespace saccade
