#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "recording/event_file.h"

namespace saccade {

class InputFile;

/// How well a file fits a format, in ascending order.
enum class Match {
  none,
  possible,  ///< nothing speaks against it; the format has no mark (text)
  likely,    ///< the content looks like it, without the format's mark
  cut_off,   ///< the file ends inside the format's mark
  certain,   ///< the file has the format's mark
};

/// What a format is recognised by.
struct FileStart {
  std::filesystem::path path;
  std::string_view bytes;  ///< the first `most_bytes` bytes, fewer where the file is shorter

  static constexpr std::size_t most_bytes = 4096;

  /// `certain` where the file begins with `mark`, `cut_off` where it ends inside it, else `none`.
  [[nodiscard]] Match begins_with(std::string_view mark) const;
  /// Whether the first bytes are printable ASCII and white space.
  [[nodiscard]] bool is_text() const;
  /// Whether a line but the first one begins with another character than `mark`.
  [[nodiscard]] bool has_line_without(char mark) const;
};

/// One format of recordings: a row of FormatRegistry. Everything that depends on the format, lists in messages and in
/// docs/recordings.md too, comes from here.
struct RecordingFormat {
  std::string name;  ///< "AEDAT 4.0"
  std::vector<std::string>
      extensions;  ///< ".h5", ".hdf5": the first one is that of a run folder's event file
  /// Name of the file that makes a folder a recording of this format ("data.log"); empty: none does.
  std::string file_in_folder;
  /// Name of a file that makes a folder, with one file that has one of the extensions, such a recording ("metadata.yaml");
  /// empty: none does.
  std::string folder_mark;

  std::function<Match(const FileStart&)> sniff;
  /// Opens a file that `sniff` has matched. Throws InputError for a broken header.
  std::function<std::unique_ptr<EventReader>(InputFile, const EventReadOptions&)> open;
  /// Creates a file for images of this size and up to `cameras` cameras. Empty: the format is only read. Throws
  /// InputError where the format cannot hold such images.
  std::function<std::unique_ptr<EventWriter>(const std::filesystem::path&, ImageSize, int cameras)> create;
  /// Further files that `create` writes beside the given one; empty: none.
  std::function<std::vector<std::filesystem::path>(const std::filesystem::path&)> companions;

  int cameras = 1;                         ///< that a written file can hold: 1 or 2
  std::optional<ImageSize> largest_size;   ///< of an image in a written file; none: not stated
  std::optional<ImageSize> size_of_two;    ///< the only image size with two cameras; none: any size
  std::optional<std::int64_t> longest_us;  ///< duration that a written file can hold; none: no limit
  bool read_in_helper = false;             ///< `open` starts a helper process (recording/helper_reader.h)

  /// Columns of the table in docs/recordings.md, in Markdown: what is read and written, time, axes and polarity as
  /// stored, limits of written files.
  std::string reads, writes, time, axes, limits;
};

/// The formats of recordings that a program reads and writes. A value: main builds it and passes it on. A copy is cheap
/// and does not change when formats are added to the original.
class FormatRegistry {
 public:
  FormatRegistry() = default;
  /// A format's name, and the extensions of a format that is written, must be new: aborts otherwise.
  void add(RecordingFormat format);

  /// Valid as long as this registry, hence not of a temporary one.
  [[nodiscard]] std::span<const RecordingFormat> formats() const& { return *formats_; }
  std::span<const RecordingFormat> formats() && = delete;
  /// Names for messages: "AEDAT 1.0, AEDAT 2.0, ... or text".
  [[nodiscard]] std::string names() const;

  /// The format of the best match; the earlier one of two that match equally well. Throws InputError for an unknown
  /// format and for a file that ends inside a format's mark.
  [[nodiscard]] const RecordingFormat& recognise(const FileStart& start) const;
  /// The format of that name, in upper or lower case. Throws InputError for an unknown one.
  [[nodiscard]] const RecordingFormat& named(std::string_view name) const;
  /// The written format that a file name's extension selects. Throws InputError for another extension.
  [[nodiscard]] const RecordingFormat& for_writing(const std::filesystem::path& path) const;
  /// The recording inside a folder, `path` itself where it is no such folder. Throws InputError for a folder with a format's
  /// mark (RecordingFormat::folder_mark) and no recording, or several.
  [[nodiscard]] std::filesystem::path file_of(const std::filesystem::path& path) const;

  /// Extensions of written files that hold at least so many cameras, sorted: ".aedat, .aedat4, .csv".
  [[nodiscard]] std::string written_extensions(int cameras = 1) const;
  /// Choices of a run's `output.events`, sorted: the first extension of each written format without its dot. `live`:
  /// without formats that limit the duration.
  [[nodiscard]] std::vector<std::string> run_choices(bool live = false) const;
  /// The choices whose files hold so many cameras of this image size.
  [[nodiscard]] std::vector<std::string> run_choices_for(ImageSize size, int cameras) const;
  /// All files that writing `path` leaves: `path` and its companions.
  [[nodiscard]] std::vector<std::filesystem::path> files_of(const std::filesystem::path& path) const;
  /// All files that reading `path` may use: `path` and the companions of formats with its extension.
  [[nodiscard]] std::vector<std::filesystem::path> inputs_of(const std::filesystem::path& path) const;

 private:
  std::shared_ptr<const std::vector<RecordingFormat>> formats_ =
      std::make_shared<std::vector<RecordingFormat>>();
};

/// The formats of this library.
[[nodiscard]] FormatRegistry built_in_formats();

}  // namespace saccade
