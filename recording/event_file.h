#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/event.h"
#include "recording/event_columns.h"

namespace saccade {

class FormatRegistry;
class OtherRecords;

/// Recorded events as a stream; files larger than memory are read in pieces. recording/format_registry.h has the formats.
class EventReader {
 public:
  virtual ~EventReader() = default;

  /// Appends up to `max_events` further events, in file order and in the file's own clock (us); time that goes back in the
  /// file goes back here. Returns their number; 0 at the end. Where the content is broken the events before that place
  /// come first, then every further call throws InputError with file and byte offset or line.
  virtual std::size_t read(std::vector<Event>& events, std::size_t max_events) = 0;
  /// From a header, or from the format; none where a file has no size. Events outside it, where a format can hold such, are
  /// returned.
  [[nodiscard]] virtual std::optional<ImageSize> image_size() const = 0;
  [[nodiscard]] virtual std::string format() const = 0;  ///< "AEDAT 2.0 DVS128", "text"
  /// Records that read() has skipped because they are no events of a camera ("12 skin events"); often empty.
  [[nodiscard]] virtual std::string skipped() const { return {}; }
  /// What was guessed because neither the file nor an option says it, though events are wrong where the guess is: "the image
  /// size 346x260, from the addresses; --size sets it". Empty: nothing was.
  [[nodiscard]] virtual std::string guess() const { return {}; }
  /// The clock of the host that recorded the file minus the clock of the events, us, as far as the events read so far say:
  /// the smallest difference between a packet's host time and its last event. None where the file has no host time.
  [[nodiscard]] virtual std::optional<std::int64_t> host_ahead_us() const { return std::nullopt; }
  /// After read() threw InputError: the first byte of the record that is broken. None where the format cannot say.
  [[nodiscard]] virtual std::optional<std::uint64_t> broken_record() const { return std::nullopt; }
  /// Then: whether that record is whole and wrong, so that the file is not cut off there.
  [[nodiscard]] virtual bool breaks_inside() const { return false; }

  /// The file, for messages; empty for a reader that open_event_file did not make.
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  void set_path(std::filesystem::path path) { path_ = std::move(path); }

 private:
  std::filesystem::path path_;
};

/// Properties that a file may not have.
struct EventReadOptions {
  /// Order of the columns of text and of arrays, by the letters t, x, y and p, c for the camera and _ for a column that is not
  /// read; auto: that of the file's own names, else txyp.
  std::string columns = "auto";
  /// Of times in text, NumPy's arrays and HDF5; none: the file's own, else us or s as the format has them.
  std::optional<TimeUnit> time_unit = std::nullopt;
  /// The sensor's size where the file has none.
  std::optional<ImageSize> image_size;
  /// Address layout of AEDAT 1.0 and 2.0: auto, dvs128, stereo, dvs640 or davis.
  std::string aedat2_layout = "auto";
  /// Only this camera's events (Event::camera); none: all.
  std::optional<std::uint8_t> camera = std::nullopt;
  /// Layout of an event-driven log's words: auto, or a name of recording/yarp_codec.h.
  std::string yarp_codec = "auto";
  /// Encoding of Prophesee RAW: auto (that of the header, else guessed), evt2, evt21, evt21_legacy or evt3.
  std::string evt_encoding = "auto";
  /// Direction of y in an Event Stream file: up, as the format defines, or down.
  std::string event_stream_y = "up";
  /// Name of the recording's format; auto: by its content.
  std::string format = "auto";
  /// Takes frames, inertial readings and triggers of AEDAT 2.0 and 4.0, Prophesee RAW, bags and MCAP (recording/other_records.h);
  /// null: they are skipped. Lives as long as the reader.
  OtherRecords* others = nullptr;
};

/// Opens a recording of one of `formats`, chosen by the file's content; of a folder the log in it (data.log). Throws
/// InputError (missing, unreadable, empty, unknown format, broken header).
[[nodiscard]] std::unique_ptr<EventReader> open_event_file(const FormatRegistry& formats,
                                                           const std::filesystem::path& path,
                                                           const EventReadOptions& options = {});
/// The same with built_in_formats().
[[nodiscard]] std::unique_ptr<EventReader> open_event_file(const std::filesystem::path& path,
                                                           const EventReadOptions& options = {});

/// Writes events in the order given; the file appears under its name on commit() only.
class EventWriter {
 public:
  virtual ~EventWriter() = default;
  /// Throws InputError for an event that the format cannot hold exactly (outside the image, of another camera, a time out
  /// of range), and RunError when writing fails.
  virtual void write(std::span<const Event> events) = 0;
  /// Puts the events so far on the disk, in records that a reader finds in the unfinished file; that file remains from then
  /// on, as OutputFile::sync() has it. Does nothing where the format cannot be read before commit() (NumPy, HDF5). Throws
  /// RunError.
  virtual void sync() {}
  virtual void commit() = 0;
};

/// Creates a recording; the extension selects one of `formats`. `cameras`: 1, or 2 where events of the right camera may
/// be written. Throws InputError for another extension, and where the format cannot hold such images.
[[nodiscard]] std::unique_ptr<EventWriter> create_event_file(const FormatRegistry& formats,
                                                             const std::filesystem::path& path,
                                                             ImageSize image_size, int cameras = 1);
/// The same with built_in_formats().
[[nodiscard]] std::unique_ptr<EventWriter> create_event_file(const std::filesystem::path& path,
                                                             ImageSize image_size, int cameras = 1);

}  // namespace saccade
