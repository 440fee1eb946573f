#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <string>

#include "evaluation/report/run_data.h"
#include "recording/event_file.h"

namespace saccade {

struct FilmConfig {
  double speed = 1.0;       ///< time of the recording per time of the film, above 0
  double window_ms = 10.0;  ///< an image shows the events of so long before it, above 0
  double from_s = 0.0;      ///< after the first event
  double until_s = std::numeric_limits<double>::infinity();
  std::string name;  ///< in the line below the images
};

struct FilmResult {
  std::int64_t images = 0;
  std::string guess;  ///< as EventReader::guess()
};

/// Draws a film of a recording: events, and what the tables of `run` say of circles and gaze; of a recording that is no run, `run` has
/// the true circles alone, where they are known. Two cameras are drawn side by side. The recording is read twice; events
/// outside its image are left out. `progress`: called with the share that is done; it may throw, and no film is written then.
/// Throws InputError for a recording without events in the time asked for, or that cannot be read, and VideoFile's errors.
FilmResult write_film(const FormatRegistry& formats, const std::filesystem::path& events,
                      const EventReadOptions& options, RunData run, const std::filesystem::path& out,
                      const FilmConfig& config, const std::function<void(double)>& progress = {});

}  // namespace saccade
