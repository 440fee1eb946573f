#include "recording/event_file.h"

#include <algorithm>
#include <charconv>

#include "core/error.h"
#include "recording/aedat2_codec.h"
#include "recording/aedat3_codec.h"
#include "recording/aedat4_codec.h"
#include "recording/codec.h"
#include "recording/dat_codec.h"
#include "recording/event_stream_codec.h"
#include "recording/evt_codec.h"
#include "recording/hdf5_codec.h"
#include "recording/text_codec.h"
#include "recording/yarp_log_codec.h"

namespace saccade {
namespace {

constexpr std::string_view aedat_mark = "#!AER-DAT";
constexpr std::string_view aedat1_mark = "#!AER-DAT1.0";
constexpr std::string_view aedat2_mark = "#!AER-DAT2.0";
constexpr std::string_view aedat3_mark = "#!AER-DAT3.1";
constexpr std::string_view aedat4_mark = "#!AER-DAT4.0";
constexpr std::string_view event_stream_mark = "Event Stream";
constexpr std::string_view hdf5_mark = "\x89HDF\r\n\x1a\n";
constexpr std::string_view known_formats =
    "a recording in a known format (AEDAT 1.0, 2.0, 3.1 or 4.0, RAW of EVT2 or EVT3, DAT, Event Stream, "
    "HDF5, "
    "an event-driven log, or text: t x y p)";

bool is_text(std::string_view bytes) {
  return std::all_of(bytes.begin(), bytes.end(), [](char c) {
    return static_cast<unsigned char>(c) >= 0x20 || c == '\n' || c == '\r' || c == '\t';
  });
}

/// One camera's events out of a recording.
class OneCameraReader final : public EventReader {
 public:
  OneCameraReader(std::unique_ptr<EventReader> reader, std::uint8_t camera)
      : reader_(std::move(reader)), camera_(camera) {}

  std::size_t read(std::vector<Event>& events, std::size_t max_events) override {
    const std::size_t before = events.size();
    while (events.size() == before) {
      if (reader_->read(events, max_events) == 0) return 0;
      const auto others = std::remove_if(events.begin() + static_cast<std::ptrdiff_t>(before), events.end(),
                                         [&](const Event& e) { return e.camera != camera_; });
      events.erase(others, events.end());
    }
    return events.size() - before;
  }
  std::optional<ImageSize> image_size() const override { return reader_->image_size(); }
  std::string format() const override { return reader_->format(); }
  std::string passed_over() const override { return reader_->passed_over(); }

 private:
  std::unique_ptr<EventReader> reader_;
  std::uint8_t camera_;
};

/// Of a folder as YARP's dumpers leave it the log in it.
std::filesystem::path log_in(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_directory(path, error)) return path;
  for (const char* name : {"data.log", "binaryevents.log"}) {
    if (std::filesystem::exists(path / name, error)) return path / name;
  }
  return path;
}

/// RAW or DAT, which begin alike: RAW names its encoding, DAT says what it is.
std::unique_ptr<EventReader> open_prophesee(InputFile file, std::string_view start,
                                            const EventReadOptions& options) {
  const auto has_line = [&](std::string_view line) { return start.find(line) != std::string_view::npos; };
  if (has_line("% evt ") || has_line("% format ")) return open_evt(std::move(file), options);
  if (has_line("% Data file containing ") || has_line("% Version "))
    return open_dat(std::move(file), options);
  throw InputError(file.name(), "a header that names no encoding of events",
                   "a line % evt or % format (RAW), or % Version (DAT)");
}

std::unique_ptr<EventReader> open_all(const std::filesystem::path& path, const EventReadOptions& options) {
  InputFile file(path);
  if (is_yarp_binary(path)) return open_yarp_binary(std::move(file), options);
  const std::string_view start = file.peek(4096).substr(0, 4096);
  if (start.starts_with(aedat1_mark)) return open_aedat1(std::move(file), options);
  if (start.starts_with(aedat2_mark)) return open_aedat2(std::move(file), options);
  if (start.starts_with(aedat3_mark)) return open_aedat3(std::move(file), options);
  if (start.starts_with(aedat4_mark)) return open_aedat4(std::move(file), options);
  if (start.starts_with(event_stream_mark)) return open_event_stream(std::move(file));
  if (start.starts_with(hdf5_mark)) return open_hdf5(path, options);
  if (start.starts_with('%')) return open_prophesee(std::move(file), start, options);
  const auto is_cut = [&](std::string_view mark) { return mark.starts_with(start); };
  if (is_cut(aedat1_mark) || is_cut(aedat2_mark) || is_cut(aedat3_mark) || is_cut(aedat4_mark) ||
      is_cut(event_stream_mark)) {
    throw InputError(file.name(), "a file cut off inside its first line", std::string(known_formats));
  }
  const bool names_version = start.substr(0, start.find('\n')).find("AER-DAT") != std::string_view::npos;
  if (start.starts_with("# ") && !names_version && !is_text(start)) {
    return open_aedat1(std::move(file), options);
  }
  if (looks_like_yarp_log(start)) return open_yarp_log(std::move(file), options);
  if (!start.starts_with(aedat_mark) && is_text(start)) return open_text(std::move(file), options);
  throw InputError(file.name(), "a file that starts with " + printable(start.substr(0, 16)),
                   std::string(known_formats));
}

}  // namespace

bool is_log_folder(const std::filesystem::path& path) { return log_in(path) != path; }

std::string writable_formats() { return ".aedat, .aedat4, .csv, .h5, .hdf5, .log, .raw, .txt"; }

std::unique_ptr<EventReader> open_event_file(const std::filesystem::path& path,
                                             const EventReadOptions& options) {
  std::unique_ptr<EventReader> reader = open_all(log_in(path), options);
  if (!options.camera) return reader;
  return std::make_unique<OneCameraReader>(std::move(reader), *options.camera);
}

std::unique_ptr<EventWriter> create_event_file(const std::filesystem::path& path, ImageSize image_size,
                                               int cameras) {
  SACCADE_CHECK(cameras == 1 || cameras == 2);
  const std::string extension = path.extension().string();
  if (extension == ".csv" || extension == ".txt") return create_text(path, image_size, cameras);
  if (extension == ".aedat") return create_aedat2(path, image_size, cameras);
  if (extension == ".aedat4") return create_aedat4(path, image_size, cameras);
  if (extension == ".h5" || extension == ".hdf5") return create_hdf5(path, image_size, cameras);
  if (extension == ".log") return create_yarp_log(path, image_size, cameras);
  if (extension == ".raw") return create_evt3(path, image_size, cameras);
  throw InputError(path.string(), extension.empty() ? "no extension" : "the extension " + extension,
                   "one of " + writable_formats());
}

void check_writable(const Event& event, ImageSize image_size, int cameras,
                    const std::filesystem::path& path) {
  if (!image_size.contains(event.x, event.y)) {
    throw InputError(path.string(), "an event at " + std::to_string(event.x) + ", " + std::to_string(event.y),
                     "pixels inside " + text_of(image_size));
  }
  if (event.camera >= cameras) {
    throw InputError(path.string(), "an event of camera " + std::to_string(event.camera),
                     cameras == 1 ? "events of the left camera alone" : "events of camera 0 or 1");
  }
}

std::optional<ImageSize> parse_size(std::string_view text) {
  ImageSize size;
  const char* end = text.data() + text.size();
  const auto width = std::from_chars(text.data(), end, size.width);
  if (width.ec != std::errc() || width.ptr == end || *width.ptr != 'x') return std::nullopt;
  if (std::from_chars(width.ptr + 1, end, size.height).ec != std::errc()) return std::nullopt;
  return size;
}

std::string text_of(ImageSize size) { return std::to_string(size.width) + "x" + std::to_string(size.height); }

void append_count(std::string& text, std::int64_t count, std::string_view what) {
  if (count == 0) return;
  if (!text.empty()) text += ", ";
  text += std::to_string(count) + " " + std::string(what);
}

std::string printable(std::string_view bytes) {
  constexpr std::size_t longest = 60;
  std::string text(bytes.substr(0, longest));
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c < 0x20 || c > 0x7e; }, '.');
  return bytes.size() > longest ? text + "..." : text;
}

}  // namespace saccade
