#include "recording/event_stream_codec.h"

#include "recording/block_reader.h"
#include "recording/byte_order.h"
#include "recording/codec.h"
#include "recording/input_file.h"

namespace saccade {
namespace {

constexpr std::size_t mark_bytes = 12;
constexpr std::size_t stream_header_bytes = 20;
constexpr std::size_t dvs_event_bytes = 5;
constexpr unsigned char overflow = 0xff;
constexpr unsigned char reset = 0xfe;

class EventStreamReader final : public BlockReader {
 public:
  EventStreamReader(InputFile file, const EventReadOptions& options) : BlockReader(std::move(file)) {
    if (options.event_stream_y != "up" && options.event_stream_y != "down")
      throw InputError("event_stream_y", options.event_stream_y, "up or down");
    y_up_ = options.event_stream_y == "up";
    const std::string_view head = file_.peek(stream_header_bytes);
    if (head.size() < mark_bytes + 4) file_.fail("the end of the file", "version and type");
    const int major = static_cast<unsigned char>(head[mark_bytes]);
    if (major != 2) file_.fail("Event Stream " + std::to_string(major), "version 2");
    const int type = static_cast<unsigned char>(head[mark_bytes + 3]);
    if (type != 1) {
      file_.fail("events of type " + std::to_string(type),
                 "1, those of a DVS (0 generic, 2 ATIS and 4 colour are not read)");
    }
    if (head.size() < stream_header_bytes) file_.fail("the end of the file", "width and height");
    image_size_ = {load_little<std::uint16_t>(head.data() + mark_bytes + 4),
                   load_little<std::uint16_t>(head.data() + mark_bytes + 6)};
    if (image_size_.width == 0 || image_size_.height == 0) {
      file_.fail("an image of " + text_of(image_size_), "at least one pixel");
    }
    file_.skip(stream_header_bytes);
  }

  std::optional<ImageSize> image_size() const override { return image_size_; }
  std::string format() const override { return y_up_ ? "Event Stream 2 DVS" : "Event Stream 2 DVS (y down)"; }
  std::string skipped() const override {
    std::string text;
    append_count(text, resets_, "resets");
    return text;
  }

 protected:
  bool decode(std::span<Event> block, std::size_t& count) override {
    const std::string_view ahead = file_.peek(dvs_event_bytes);
    if (ahead.empty()) return false;
    const auto last_y = static_cast<std::uint32_t>(image_size_.height - 1);
    std::size_t i = 0;
    while (i < ahead.size() && count < block.size()) {
      const auto first = static_cast<unsigned char>(ahead[i]);
      if (first == overflow) t_us_ += 127;
      if (first == reset) ++resets_;
      if (first >= reset) {
        ++i;
        continue;
      }
      if (ahead.size() - i < dvs_event_bytes) break;
      t_us_ += first >> 1;
      const auto y = load_little<std::uint16_t>(ahead.data() + i + 3);
      block[count++] = {t_us_, load_little<std::uint16_t>(ahead.data() + i + 1),
                        y_up_ ? mirrored(y, last_y) : y, (first & 1) != 0, 0};
      i += dvs_event_bytes;
    }
    file_.skip(i);
    if (i == 0) file_.fail("the end of the file inside an event", "events of 5 bytes");
    return true;
  }

 private:
  bool y_up_ = true;
  ImageSize image_size_;
  std::int64_t t_us_ = 0;
  std::int64_t resets_ = 0;
};

}  // namespace

RecordingFormat event_stream_format() {
  RecordingFormat format;
  format.name = "Event Stream 2";
  format.extensions = {".es"};
  format.sniff = [](const FileStart& start) { return start.begins_with("Event Stream"); };
  format.open = [](InputFile file, const EventReadOptions& options) -> std::unique_ptr<EventReader> {
    return std::make_unique<EventStreamReader>(std::move(file), options);
  };
  format.reads = "type DVS";
  format.time = "us, as differences";
  format.axes = "bottom left, y up, with `--es-y down` top left; 1 is ON";
  return format;
}

}  // namespace saccade
