#include "recording/event_file.h"

#include <algorithm>

#include "core/error.h"
#include "recording/format_registry.h"
#include "recording/input_file.h"

namespace saccade {
namespace {

/// The events of one camera of a recording.
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
  std::string skipped() const override { return reader_->skipped(); }
  std::string guess() const override { return reader_->guess(); }
  std::optional<std::int64_t> host_ahead_us() const override { return reader_->host_ahead_us(); }
  std::optional<std::uint64_t> broken_record() const override { return reader_->broken_record(); }
  bool breaks_inside() const override { return reader_->breaks_inside(); }

 private:
  std::unique_ptr<EventReader> reader_;
  std::uint8_t camera_;
};

}  // namespace

std::unique_ptr<EventReader> open_event_file(const FormatRegistry& formats, const std::filesystem::path& path,
                                             const EventReadOptions& options) {
  const std::filesystem::path recording = formats.file_of(path);
  InputFile file(recording);
  const FileStart start{recording, file.peek(FileStart::most_bytes).substr(0, FileStart::most_bytes)};
  const RecordingFormat& format =
      options.format == "auto" ? formats.recognise(start) : formats.named(options.format);
  std::unique_ptr<EventReader> reader = format.open(std::move(file), options);
  if (options.camera) reader = std::make_unique<OneCameraReader>(std::move(reader), *options.camera);
  reader->set_path(recording);
  return reader;
}

std::unique_ptr<EventReader> open_event_file(const std::filesystem::path& path,
                                             const EventReadOptions& options) {
  return open_event_file(built_in_formats(), path, options);
}

std::unique_ptr<EventWriter> create_event_file(const FormatRegistry& formats,
                                               const std::filesystem::path& path, ImageSize image_size,
                                               int cameras) {
  SACCADE_CHECK(cameras == 1 || cameras == 2);
  const RecordingFormat& format = formats.for_writing(path);
  if (cameras > format.cameras) {
    throw InputError(path.string(), "two cameras",
                     "one camera in " + format.name + ", or one of " + formats.written_extensions(cameras));
  }
  return format.create(path, image_size, cameras);
}

std::unique_ptr<EventWriter> create_event_file(const std::filesystem::path& path, ImageSize image_size,
                                               int cameras) {
  return create_event_file(built_in_formats(), path, image_size, cameras);
}

}  // namespace saccade
