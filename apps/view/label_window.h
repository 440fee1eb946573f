#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "session/replay_source.h"

namespace saccade {

/// What `saccade label` opens and writes.
struct LabelSettings {
  ReadOptions input;
  std::filesystem::path out;             ///< truth.csv; its circles are loaded if it exists
  std::filesystem::path pictures = ".";  ///< folder of screenshots
  double step_ms = 1.0;                  ///< of the arrow keys
};

/// Opens a window in which a person places the true circles of a recording at instants, and writes them. Returns when the
/// window is closed; after Ctrl-C too, when it writes what is not saved yet. Throws InputError for a broken recording or
/// table and where there is no display, RunError where the table cannot be written.
void label_recording(const LabelSettings& settings);

}  // namespace saccade
