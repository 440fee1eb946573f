#include "recording/dat_codec.h"

#include <algorithm>

#include "recording/block_reader.h"
#include "recording/byte_order.h"
#include "recording/codec.h"
#include "recording/input_file.h"
#include "recording/prophesee_header.h"
#include "recording/wrapping_time.h"

namespace saccade {
namespace {

constexpr std::size_t dat_event_bytes = 8;

struct Version1 {
  static std::uint32_t x(std::uint32_t address) { return address & 0x1ff; }
  static std::uint32_t y(std::uint32_t address) { return address >> 9 & 0xff; }
  static bool on(std::uint32_t address) { return (address >> 17 & 1) != 0; }
};
struct Version2 {
  static std::uint32_t x(std::uint32_t address) { return address & 0x3fff; }
  static std::uint32_t y(std::uint32_t address) { return address >> 14 & 0x3fff; }
  static bool on(std::uint32_t address) { return (address >> 28 & 1) != 0; }
};

class DatReader final : public BlockReader {
 public:
  DatReader(InputFile file, const EventReadOptions& options) : BlockReader(std::move(file)) {
    const PropheseeHeader header(file_);
    const std::string version = header.value("version");
    if (version != "" && version != "1" && version != "2") {
      file_.fail("version " + printable(version), "DAT of version 1 or 2");
    }
    version_ = version == "2" ? 2 : 1;
    const std::optional<ImageSize> size = header.image_size();
    image_size_ = size ? size : options.image_size;
    const std::string_view kind = file_.peek(2);
    if (kind.size() < 2) file_.fail("the end of the file", "the events' type and size");
    const auto type = static_cast<unsigned char>(kind[0]);
    if (type != 0x00 && type != 0x0c) {
      file_.fail("events of type " + std::to_string(type), "0 or 12, events of pixels");
    }
    if (kind[1] != dat_event_bytes) {
      file_.fail("events of " + std::to_string(static_cast<unsigned char>(kind[1])) + " bytes", "8 bytes");
    }
    file_.skip(2);
  }

  std::optional<ImageSize> image_size() const override { return image_size_; }
  std::string format() const override { return "DAT " + std::to_string(version_); }

 protected:
  bool decode(std::span<Event> block, std::size_t& count) override {
    return version_ == 2 ? decode_as<Version2>(block, count) : decode_as<Version1>(block, count);
  }

 private:
  template <class Version>
  bool decode_as(std::span<Event> block, std::size_t& count) {
    const std::string_view ahead = file_.peek(dat_event_bytes);
    if (ahead.empty()) return false;
    const std::size_t events = std::min(ahead.size() / dat_event_bytes, block.size());
    if (events == 0) file_.fail("the end of the file inside an event", "events of 8 bytes");
    for (; count < events; ++count) {
      const char* bytes = ahead.data() + count * dat_event_bytes;
      const auto address = load_little<std::uint32_t>(bytes + 4);
      block[count] = {time_.extend(load_little<std::uint32_t>(bytes)),
                      static_cast<std::uint16_t>(Version::x(address)),
                      static_cast<std::uint16_t>(Version::y(address)), Version::on(address), 0};
    }
    file_.skip(events * dat_event_bytes);
    return true;
  }

  int version_ = 1;
  std::optional<ImageSize> image_size_;
  WrappingTime time_{{{0, std::int64_t{1} << 32}}, std::int64_t{1} << 29, std::int64_t{1} << 24};
};

}  // namespace

RecordingFormat prophesee_dat_format() {
  RecordingFormat format;
  format.name = "Prophesee DAT";
  format.extensions = {".dat"};
  format.sniff = [](const FileStart& start) {
    const auto has = [&](std::string_view key) { return start.bytes.find(key) != std::string_view::npos; };
    const bool fits = start.bytes.starts_with('%') && (has("% Data file containing ") || has("% Version "));
    return fits ? Match::certain : Match::none;
  };
  format.open = [](InputFile file, const EventReadOptions& options) -> std::unique_ptr<EventReader> {
    return std::make_unique<DatReader>(std::move(file), options);
  };
  format.reads = "versions 1 and 2, events of pixels";
  format.time = "u32 us, continued over its wraps at 2^32";
  format.axes = "top left, 1 is ON";
  return format;
}

}  // namespace saccade
