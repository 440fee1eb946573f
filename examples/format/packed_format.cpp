#include "packed_format.h"

#include <algorithm>

#include "recording/byte_order.h"
#include "recording/codec.h"
#include "recording/input_file.h"
#include "recording/output_file.h"

namespace example {
namespace {

constexpr std::string_view mark = "PACKED1\n";
constexpr std::size_t event_bytes = 13;

class PackedReader final : public saccade::EventReader {
 public:
  explicit PackedReader(saccade::InputFile file) : file_(std::move(file)) {
    const std::string_view head = file_.peek(mark.size() + 4);
    if (head.size() < mark.size() + 4) file_.fail("the end of the file", "width and height");
    size_ = {saccade::load_little<std::uint16_t>(head.data() + mark.size()),
             saccade::load_little<std::uint16_t>(head.data() + mark.size() + 2)};
    file_.skip(mark.size() + 4);
  }

  std::size_t read(std::vector<saccade::Event>& events, std::size_t max_events) override {
    const std::string_view ahead = file_.peek(event_bytes);
    const std::size_t count = std::min(ahead.size() / event_bytes, max_events);
    if (count == 0 && !ahead.empty()) file_.fail("the end of the file inside an event", "events of 13 bytes");
    for (std::size_t i = 0; i < count; ++i) {
      const char* const bytes = ahead.data() + i * event_bytes;
      events.push_back({saccade::load_little<std::int64_t>(bytes),
                        saccade::load_little<std::uint16_t>(bytes + 8),
                        saccade::load_little<std::uint16_t>(bytes + 10), bytes[12] != 0, 0});
    }
    file_.skip(count * event_bytes);
    return count;
  }
  std::optional<saccade::ImageSize> image_size() const override { return size_; }
  std::string format() const override { return "packed"; }

 private:
  saccade::InputFile file_;
  saccade::ImageSize size_;
};

class PackedWriter final : public saccade::EventWriter {
 public:
  PackedWriter(const std::filesystem::path& path, saccade::ImageSize size) : file_(path), size_(size) {
    std::string head(mark);
    saccade::append_little(head, static_cast<std::uint16_t>(size.width));
    saccade::append_little(head, static_cast<std::uint16_t>(size.height));
    file_.write(head);
  }

  void write(std::span<const saccade::Event> events) override {
    bytes_.clear();
    for (const saccade::Event& event : events) {
      saccade::check_writable(event, size_, 1, file_.path());
      saccade::append_little(bytes_, event.t_us);
      saccade::append_little(bytes_, event.x);
      saccade::append_little(bytes_, event.y);
      bytes_ += event.on ? '\1' : '\0';
    }
    file_.write(bytes_);
  }
  void commit() override { file_.commit(); }

 private:
  saccade::OutputFile file_;
  saccade::ImageSize size_;
  std::string bytes_;
};

}  // namespace

saccade::RecordingFormat packed_format() {
  saccade::RecordingFormat format;
  format.name = "packed";
  format.extensions = {".packed"};
  format.sniff = [](const saccade::FileStart& start) { return start.begins_with(mark); };
  format.open = [](saccade::InputFile file, const saccade::EventReadOptions&) {
    return std::unique_ptr<saccade::EventReader>(std::make_unique<PackedReader>(std::move(file)));
  };
  format.create = [](const std::filesystem::path& path, saccade::ImageSize size, int) {
    return std::unique_ptr<saccade::EventWriter>(std::make_unique<PackedWriter>(path, size));
  };
  return format;
}

}  // namespace example
