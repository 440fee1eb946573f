#include "recording/nmnist_codec.h"

#include <algorithm>

#include "recording/block_reader.h"
#include "recording/byte_order.h"
#include "recording/input_file.h"
#include "recording/wrapping_time.h"

namespace saccade {
namespace {

constexpr std::size_t nmnist_event_bytes = 5;
constexpr std::uint8_t overflow_row = 240;
constexpr std::int64_t overflow_us = std::int64_t{1} << 13;

struct NmnistRecord {
  std::uint8_t x, y;
  bool on;
  std::int64_t stamp;

  explicit NmnistRecord(const char* bytes)
      : x(static_cast<std::uint8_t>(bytes[0])),
        y(static_cast<std::uint8_t>(bytes[1])),
        on((static_cast<unsigned char>(bytes[2]) & 0x80) != 0),
        stamp(load_big<std::uint32_t>(bytes + 1) & 0x7fffff) {}
};

bool looks_like_nmnist(std::string_view bytes) {
  std::int64_t records = 0, bad = 0, last = 0;
  for (; bytes.size() >= nmnist_event_bytes; bytes.remove_prefix(nmnist_event_bytes)) {
    const NmnistRecord record(bytes.data());
    ++records;
    bad += record.x >= overflow_row || record.y > overflow_row ||
                   (record.y < overflow_row && record.stamp < last)
               ? 1
               : 0;
    last = record.y == overflow_row ? 0 : record.stamp;
  }
  return bad * 100 <= records;
}

class NmnistReader final : public BlockReader {
 public:
  NmnistReader(InputFile file, const EventReadOptions& options)
      : BlockReader(std::move(file)), image_size_(options.image_size) {}

  std::optional<ImageSize> image_size() const override { return image_size_; }
  std::string format() const override { return "N-MNIST"; }

 protected:
  bool decode(std::span<Event> block, std::size_t& count) override {
    const std::string_view ahead = file_.peek(nmnist_event_bytes);
    if (ahead.empty()) return false;
    const std::size_t records = std::min(ahead.size() / nmnist_event_bytes, block.size());
    if (records == 0) file_.fail("the end of the file inside an event", "events of 5 bytes");
    for (std::size_t i = 0; i < records; ++i) {
      const NmnistRecord record(ahead.data() + i * nmnist_event_bytes);
      if (record.y == overflow_row) added_us_ += overflow_us;
      block[count] = {time_.extend(record.stamp) + added_us_, record.x, record.y, record.on, 0};
      count += record.y == overflow_row ? 0 : 1;
    }
    file_.skip(records * nmnist_event_bytes);
    return true;
  }

 private:
  std::optional<ImageSize> image_size_;
  std::int64_t added_us_ = 0;
  WrappingTime time_{{{0, std::int64_t{1} << 23}}, std::int64_t{1} << 21, std::int64_t{1} << 17};
};

}  // namespace

RecordingFormat nmnist_format() {
  RecordingFormat format;
  format.name = "N-MNIST";
  format.extensions = {".bin"};
  format.sniff = [](const FileStart& start) {
    return start.path.extension() == ".bin" && looks_like_nmnist(start.bytes) ? Match::possible : Match::none;
  };
  format.open = [](InputFile file, const EventReadOptions& options) -> std::unique_ptr<EventReader> {
    return std::make_unique<NmnistReader>(std::move(file), options);
  };
  format.reads =
      "events of 5 bytes, N-Caltech101's too; by the extension, checked against the first events, or by "
      "`--format N-MNIST`";
  format.time = "23 bits of us, continued over their wraps; records with y 240 add 2^13 us";
  format.axes = "top left, 1 is ON";
  return format;
}

}  // namespace saccade
