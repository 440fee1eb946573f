#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <optional>
#include <string>

#include "recording/event_file.h"
#include "recording/recording_summary.h"

namespace saccade {

/// A rectangle of pixels.
struct PixelRegion {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;

  [[nodiscard]] bool contains(const Event& e) const {
    return ImageSize{width, height}.contains(e.x - x, e.y - y);
  }
};

/// Which events of a recording are copied, and how they are changed, in the order of the members.
struct ConversionConfig {
  /// With `camera`, that camera's events are written as those of the only camera. `others` gets what the recording holds besides
  /// events within from_s and until_s, its times changed as those of events, frames also by crop, swap_xy, flip_x and
  /// flip_y.
  EventReadOptions read;
  double from_s = -std::numeric_limits<double>::infinity();  ///< after the first event; included
  double until_s = std::numeric_limits<double>::infinity();  ///< after the first event; excluded
  std::optional<PixelRegion> region;                         ///< pixels of the recording
  std::optional<bool> only_on;                               ///< true: ON events alone; false: OFF
  bool remove_hot = false;                                   ///< all events of hot pixels, see event_filter.h
  bool remove_background = false;  ///< events without another one near them, see event_filter.h
  std::int64_t decimate =
      1;  ///< of each pixel's events, of each polarity, every so manieth is kept, from the first on
  bool invert = false;     ///< ON becomes OFF and OFF becomes ON
  bool zero_time = false;  ///< the first event written is at 0 us
  bool crop = false;       ///< the region becomes the image
  bool swap_xy = false;
  bool flip_x = false;
  bool flip_y = false;
  bool remove_outside =
      false;  ///< events outside the image, where the recording states its size, are removed instead of an error
  bool whole_part =
      false;  ///< of a recording that breaks off: the events before that place instead of an error
};

struct ConversionResult {
  std::int64_t events = 0;                                                                   ///< written
  std::int64_t outside_time = 0, outside_region = 0, other_polarity = 0, outside_image = 0;  ///< removed
  std::int64_t hot = 0, background = 0, decimated = 0;                                       ///< removed
  std::int64_t hot_pixels = 0;
  std::string skipped;                         ///< EventReader::skipped()
  std::string guess;                           ///< EventReader::guess()
  std::optional<TornEnd> torn = std::nullopt;  ///< what was not read, with whole_part
};

/// Called after each block with the number of events so far, once for each of the two passes. It may throw to end the
/// conversion; then nothing is written.
using ConversionProgress = std::function<void(bool second_pass, std::int64_t events)>;

/// Copies a recording, or a part of it, into a new file of the format that the extension of `out` selects. The recording is
/// read twice: first for the number of cameras, the time of the first event and, where the file has none, the image size.
/// `out` appears when it is whole. Throws InputError for a broken recording, for events that the format cannot hold, and for frames
/// of another size than the events' image where they would have to be cropped or turned.
ConversionResult convert_recording(const FormatRegistry& formats, const std::filesystem::path& recording,
                                   const std::filesystem::path& out, const ConversionConfig& config,
                                   const ConversionProgress& progress = {});

}  // namespace saccade
