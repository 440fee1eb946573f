#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/event.h"

namespace saccade {

/// Recorded events as a stream; a file larger than memory is fine. One codec per format, chosen by the
/// file's content and name; no code outside recording/ knows a format.
class EventReader {
 public:
  virtual ~EventReader() = default;

  /// Appends up to `max_events` further events, in file order and in the file's own clock (us). Returns how
  /// many; 0 at the end. Throws InputError with file and byte offset or line where the content is broken;
  /// everything before that place has been delivered.
  virtual std::size_t read(std::vector<Event>& events, std::size_t max_events) = 0;
  /// Known from a header, or from the format; none where a file does not say.
  [[nodiscard]] virtual std::optional<ImageSize> image_size() const = 0;
  [[nodiscard]] virtual std::string format() const = 0;  ///< "AEDAT 2.0 DVS128", "text"
};

/// How to read text: column order out of t, x, y, p; by default time first, then x y p.
struct EventReadOptions {
  std::string columns = "txyp";
};

/// Opens a recording. Throws InputError (missing, unreadable, empty, unknown format).
[[nodiscard]] std::unique_ptr<EventReader> open_event_file(const std::filesystem::path& path,
                                                           const EventReadOptions& options = {});

/// Writes events in time order; the file appears under its name on commit() only.
class EventWriter {
 public:
  virtual ~EventWriter() = default;
  virtual void write(std::span<const Event> events) = 0;
  virtual void commit() = 0;
};

/// The format follows the extension: .csv and .txt text (`t_us,x,y,p`), .aedat AEDAT 2.0. Throws InputError
/// for another extension, or an image size the format cannot hold.
[[nodiscard]] std::unique_ptr<EventWriter> create_event_file(const std::filesystem::path& path,
                                                             ImageSize image_size);

}  // namespace saccade
