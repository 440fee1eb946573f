#include "recording/event_file.h"

#include <algorithm>

#include "core/error.h"
#include "recording/aedat2_codec.h"
#include "recording/aedat4_codec.h"
#include "recording/codec.h"
#include "recording/text_codec.h"
#include "recording/yarp_log_codec.h"

namespace saccade {
namespace {

constexpr std::string_view aedat_mark = "#!AER-DAT";
constexpr std::string_view aedat2_mark = "#!AER-DAT2.0";
constexpr std::string_view aedat4_mark = "#!AER-DAT4.0";
constexpr std::string_view known_formats =
    "a recording in a known format (AEDAT 2.0 or 4.0, an event-driven log, or text: t x y p)";

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
  for (const char* name : {"data.log", "binaryevents.log"}) {
    std::error_code error;
    if (std::filesystem::is_directory(path, error) && std::filesystem::exists(path / name, error))
      return path / name;
  }
  return path;
}

std::unique_ptr<EventReader> open_all(const std::filesystem::path& path, const EventReadOptions& options) {
  InputFile file(path);
  if (is_yarp_binary(path)) return open_yarp_binary(std::move(file), options);
  const std::string_view start = file.peek(4096).substr(0, 4096);
  if (start.starts_with(aedat2_mark)) return open_aedat2(std::move(file), options);
  if (start.starts_with(aedat4_mark)) return open_aedat4(std::move(file), options);
  if (aedat2_mark.starts_with(start) || aedat4_mark.starts_with(start)) {
    throw InputError(file.name(), "a file cut off inside its first line", std::string(known_formats));
  }
  if (looks_like_yarp_log(start)) return open_yarp_log(std::move(file), options);
  if (!start.starts_with(aedat_mark) && is_text(start)) return open_text(std::move(file), options);
  throw InputError(file.name(), "a file that starts with " + printable(start.substr(0, 16)),
                   std::string(known_formats));
}

}  // namespace

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
  if (extension == ".log") return create_yarp_log(path, image_size, cameras);
  throw InputError(path.string(), extension.empty() ? "no extension" : "the extension " + extension,
                   "one of .aedat, .csv, .log, .txt");
}

void check_writable(const Event& event, ImageSize image_size, int cameras,
                    const std::filesystem::path& path) {
  if (!image_size.contains(event.x, event.y)) {
    throw InputError(
        path.string(), "an event at " + std::to_string(event.x) + ", " + std::to_string(event.y),
        "pixels inside " + std::to_string(image_size.width) + "x" + std::to_string(image_size.height));
  }
  if (event.camera >= cameras) {
    throw InputError(path.string(), "an event of camera " + std::to_string(event.camera),
                     cameras == 1 ? "events of the left camera alone" : "events of camera 0 or 1");
  }
}

std::string printable(std::string_view bytes) {
  constexpr std::size_t longest = 60;
  std::string text(bytes.substr(0, longest));
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c < 0x20 || c > 0x7e; }, '.');
  return bytes.size() > longest ? text + "..." : text;
}

}  // namespace saccade
