#pragma once

#include <filesystem>

namespace saccade {

class FormatRegistry;
struct EventReadOptions;

/// Writes a page that replays a run (docs/replay.md): one file that needs no network. It shows what the folder holds: scene.json,
/// the events, truth.csv, detections.csv, gaze.csv, eye.csv, and those of the right eye; what is missing is left out. The names of
/// run, detectors and joints are those of metrics.json. `formats`: of the event file.
/// Throws InputError for a folder without a readable metrics.json or with a broken table or scene, RunError when the page cannot
/// be written. Of events that cannot be read the page says why.
void write_replay(const std::filesystem::path& run_folder, const FormatRegistry& formats,
                  const std::filesystem::path& page);

/// The same of a recording alone. Throws InputError for one that cannot be read, or has no events.
void write_recording_replay(const std::filesystem::path& recording, const FormatRegistry& formats,
                            const EventReadOptions& options, const std::filesystem::path& page);

}  // namespace saccade
