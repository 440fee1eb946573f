#include "recording/aedat2_codec.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>

#include "core/error.h"
#include "recording/codec.h"
#include "recording/output_file.h"

namespace saccade {
namespace {

constexpr std::size_t record_bytes = 8;
constexpr std::size_t longest_header_line = 4096;
constexpr std::size_t block_records = 4096;

constexpr ImageSize dvs128_size{128, 128};
constexpr ImageSize davis_largest{1024, 512};
constexpr std::array<ImageSize, 3> davis_family{{{240, 180}, {346, 260}, {640, 480}}};

std::uint32_t big_endian_u32(const char* bytes) {
  std::uint32_t value = 0;
  for (int i = 0; i < 4; ++i) value = value << 8 | static_cast<unsigned char>(bytes[i]);
  return value;
}

void put_big_endian(std::uint32_t value, char* bytes) {
  for (int i = 0; i < 4; ++i) bytes[i] = static_cast<char>(value >> (24 - 8 * i) & 0xff);
}

/// The address layouts: where a pixel is, which records are no events.
struct Dvs128 {
  static constexpr std::uint32_t special = 1u << 15;
  static std::uint8_t camera(std::uint32_t) { return 0; }
  static std::uint32_t x(std::uint32_t address) { return address >> 1 & 0x7f; }
  static std::uint32_t y(std::uint32_t address) { return address >> 8 & 0x7f; }
  static bool on(std::uint32_t address) { return (address & 1) == 0; }
  static std::uint32_t address(std::uint32_t x, std::uint32_t y, bool on) {
    return y << 8 | x << 1 | (on ? 0u : 1u);
  }
};
/// jAER's DVS128StereoPair: two DVS128, bit 15 is the right eye's.
struct StereoPair : Dvs128 {
  static constexpr std::uint32_t right = 1u << 15;
  static constexpr std::uint32_t special = 0;
  static std::uint8_t camera(std::uint32_t address) { return (address & right) != 0 ? 1 : 0; }
};
struct Davis {
  static constexpr std::uint32_t special = 1u << 31 | 1u << 10;
  static std::uint8_t camera(std::uint32_t) { return 0; }
  static std::uint32_t x(std::uint32_t address) { return address >> 12 & 0x3ff; }
  static std::uint32_t y(std::uint32_t address) { return address >> 22 & 0x1ff; }
  static bool on(std::uint32_t address) { return (address >> 11 & 1) != 0; }
  static std::uint32_t address(std::uint32_t x, std::uint32_t y, bool on) {
    return y << 22 | x << 12 | (on ? 1u : 0u) << 11;
  }
};

/// Continues 32-bit time stamps over their wraps: from the last `silence` of the range to the first one,
/// and back over a wrap for an event that comes up to `lateness` late.
class TimeUnwrapper {
 public:
  std::int64_t extend(std::int32_t stamp) {
    if (!started_) last_ = stamp;
    started_ = true;
    const std::int64_t step = stamp - last_;
    if (step < -silence || step > silence) jump(stamp);
    last_ = stamp;
    return offset_ + stamp;
  }

 private:
  static constexpr std::int64_t half = std::int64_t{1} << 31;
  static constexpr std::int64_t silence = std::int64_t{1} << 29;
  static constexpr std::int64_t lateness = std::int64_t{1} << 24;

  /// Whether `before` ends a range of which `after` begins the next one, each within `margin`.
  static bool wraps_32(std::int64_t before, std::int64_t after, std::int64_t margin) {
    return before >= half - margin && after < -half + margin;
  }
  static bool wraps_31(std::int64_t before, std::int64_t after, std::int64_t margin) {
    return before >= half - margin && after >= 0 && after < margin;
  }

  void jump(std::int64_t stamp) {
    if (wraps_32(last_, stamp, silence)) offset_ += 2 * half;
    if (wraps_31(last_, stamp, silence)) offset_ += half;
    if (wraps_32(stamp, last_, lateness) && offset_ >= 2 * half) offset_ -= 2 * half;
    if (wraps_31(stamp, last_, lateness) && offset_ >= half) offset_ -= half;
  }

  bool started_ = false;
  std::int64_t last_ = 0;
  std::int64_t offset_ = 0;
};

std::string text_of(ImageSize size) { return std::to_string(size.width) + "x" + std::to_string(size.height); }

/// What the header lines say of the sensor.
struct Sensor {
  std::string layout;  ///< "dvs128", "stereo", "davis", or empty
  std::optional<ImageSize> size;
};

std::optional<ImageSize> parse_size(std::string_view text) {
  ImageSize size;
  const char* end = text.data() + text.size();
  const auto width = std::from_chars(text.data(), end, size.width);
  if (width.ec != std::errc() || width.ptr == end || *width.ptr != 'x') return std::nullopt;
  if (std::from_chars(width.ptr + 1, end, size.height).ec != std::errc()) return std::nullopt;
  return size;
}

/// jAER's `# AEChip: eu.seebetter.ini.chips.davis.DAVIS240C`, and our own `# AEChip: DAVIS 304x240`.
Sensor parse_chip(std::string_view name) {
  std::string chip(name);
  std::transform(chip.begin(), chip.end(), chip.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (chip.find("dvs128stereopair") != std::string::npos) return {"stereo", dvs128_size};
  if (chip.find("dvs128") != std::string::npos) return {"dvs128", dvs128_size};
  const std::size_t davis = chip.rfind("davis");
  if (davis == std::string::npos) return {};
  const std::string model = chip.substr(davis + 5);
  if (model.starts_with(' ')) return {"davis", parse_size(std::string_view(model).substr(1))};
  for (const ImageSize size : davis_family) {
    if (model.starts_with(std::to_string(size.width))) return {"davis", size};
  }
  return {"davis", std::nullopt};
}

class Aedat2Reader final : public EventReader {
 public:
  Aedat2Reader(InputFile file, const EventReadOptions& options) : file_(std::move(file)) {
    Sensor sensor = read_header(options.aedat2_layout != "auto");
    if (options.aedat2_layout != "auto") sensor.layout = options.aedat2_layout;
    const Range seen = first_addresses();
    if (sensor.layout.empty()) sensor.layout = seen.wide ? "davis" : "dvs128";
    if (sensor.layout == "dvs128") {
      size_ = dvs128_size;
    } else if (sensor.layout == "stereo") {
      stereo_ = true;
      size_ = dvs128_size;
    } else if (sensor.layout == "davis") {
      davis_ = true;
      size_ = sensor.size.value_or(options.image_size.value_or(seen.davis_size));
    } else {
      throw InputError("aedat2_layout", sensor.layout, "one of auto, dvs128, stereo, davis");
    }
    if (!davis_largest.contains(size_.width - 1, size_.height - 1)) {
      throw InputError(file_.name(), "an image of " + text_of(size_), "at most " + text_of(davis_largest));
    }
  }

  std::size_t read(std::vector<Event>& events, std::size_t max_events) override {
    std::size_t count = 0;
    try {
      while (count < max_events) {
        const std::size_t more = read_block(max_events - count);
        if (more == 0 && file_.peek(1).empty()) break;
        events.insert(events.end(), block_.begin(), block_.begin() + static_cast<std::ptrdiff_t>(more));
        count += more;
      }
    } catch (const InputError&) {
      if (count == 0) throw;  // else the broken record is met again, and told, by the next call
    }
    return count;
  }

  std::optional<ImageSize> image_size() const override { return size_; }
  std::string format() const override {
    return davis_ ? "AEDAT 2.0 DAVIS" : stereo_ ? "AEDAT 2.0 DVS128StereoPair" : "AEDAT 2.0 DVS128";
  }

 private:
  /// What the first addresses of a file without a name for its sensor tell.
  struct Range {
    bool wide = false;  ///< more than the 16 bits of a DVS128
    ImageSize davis_size = davis_family.front();
  };

  /// The length of the header line ahead with its end, 0 where the records begin. A record can begin with
  /// the byte of '#' too, but has control characters in it, or another line end than the first line.
  std::size_t header_line(std::string_view line_end) {
    const std::string_view ahead = file_.peek(longest_header_line).substr(0, longest_header_line);
    if (!ahead.starts_with('#')) return 0;
    const auto control = std::find_if(
        ahead.begin(), ahead.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20 && c != '\t'; });
    const auto length = static_cast<std::size_t>(control - ahead.begin());
    if (ahead.substr(length).starts_with(line_end)) return length + line_end.size();
    const bool cut = length == ahead.size() || (ahead[length] == '\r' && length + 1 == ahead.size());
    if (cut && ahead.size() < longest_header_line) fail("the end of the file", "the rest of the header");
    return 0;
  }

  Sensor read_header(bool layout_given) {
    const std::string_view first = file_.peek(longest_header_line).substr(0, longest_header_line);
    const std::size_t newline = first.find('\n');
    const std::string_view line_end =
        newline != std::string_view::npos && newline > 0 && first[newline - 1] == '\r' ? "\r\n" : "\n";
    Sensor sensor;
    constexpr std::string_view chip_key = "# AEChip: ";
    while (const std::size_t length = header_line(line_end)) {
      const std::string_view line = file_.peek(length).substr(0, length - line_end.size());
      if (line.starts_with(chip_key)) {
        sensor = parse_chip(line.substr(chip_key.size()));
        if (sensor.layout.empty() && !layout_given) {
          fail("the chip " + printable(line.substr(chip_key.size())),
               "DVS128 or a DAVIS, or the option aedat2_layout");
        }
      }
      file_.skip(length);
    }
    return sensor;
  }

  Range first_addresses() {
    Range range;
    const std::string_view ahead = file_.peek(block_records * record_bytes);
    ImageSize needed{1, 1};
    for (std::size_t i = 0; i + record_bytes <= ahead.size(); i += record_bytes) {
      const std::uint32_t address = big_endian_u32(ahead.data() + i);
      range.wide = range.wide || address > 0xffff;
      if ((address & Davis::special) != 0) continue;
      needed.width = std::max(needed.width, static_cast<int>(Davis::x(address)) + 1);
      needed.height = std::max(needed.height, static_cast<int>(Davis::y(address)) + 1);
    }
    const auto fits = [&](ImageSize size) { return size.contains(needed.width - 1, needed.height - 1); };
    const auto sensor = std::find_if(davis_family.begin(), davis_family.end(), fits);
    range.davis_size = sensor != davis_family.end() ? *sensor : davis_largest;
    return range;
  }

  /// Decodes up to `max_events` events into block_; 0 at the end, or where there were only special records.
  std::size_t read_block(std::size_t max_events) {
    const std::string_view ahead = file_.peek(record_bytes);
    const std::size_t records = std::min({ahead.size() / record_bytes, max_events, block_records});
    if (records == 0 && !ahead.empty()) fail("the end of the file inside a record", "records of 8 bytes");
    if (stereo_) return decode<StereoPair>(ahead, records);
    return davis_ ? decode<Davis>(ahead, records) : decode<Dvs128>(ahead, records);
  }

  template <class Layout>
  std::size_t decode(std::string_view bytes, std::size_t records) {
    const auto last_x = static_cast<std::uint32_t>(size_.width - 1);
    const auto last_y = static_cast<std::uint32_t>(size_.height - 1);
    std::size_t count = 0;
    std::size_t i = 0;
    for (; i < records; ++i) {
      const std::uint32_t address = big_endian_u32(bytes.data() + i * record_bytes);
      const auto stamp = static_cast<std::int32_t>(big_endian_u32(bytes.data() + i * record_bytes + 4));
      const std::uint32_t x = last_x - Layout::x(address);
      const std::uint32_t y = last_y - Layout::y(address);
      const bool special = (address & Layout::special) != 0;
      if (!special && (x > last_x || y > last_y)) break;
      const std::int64_t t_us = time_.extend(stamp);
      block_[count] = {t_us, static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y),
                       Layout::on(address), Layout::camera(address)};
      count += special ? 0 : 1;
    }
    file_.skip(i * record_bytes);
    if (i < records && count == 0) {
      fail("a pixel outside the image of " + text_of(size_), "pixels inside it, or another image size");
    }
    return count;
  }

  [[noreturn]] void fail(std::string value, std::string expectation) const {
    throw InputError(file_.name() + ": byte " + std::to_string(file_.offset()), std::move(value),
                     std::move(expectation));
  }

  InputFile file_;
  ImageSize size_;
  bool davis_ = false;
  bool stereo_ = false;
  TimeUnwrapper time_;
  std::vector<Event> block_ = std::vector<Event>(block_records);
};

class Aedat2Writer final : public EventWriter {
 public:
  Aedat2Writer(const std::filesystem::path& path, ImageSize size, int cameras)
      : file_(path), size_(size), cameras_(cameras), davis_(size != dvs128_size) {
    const std::string chip = davis_ ? "DAVIS " + text_of(size) : cameras_ > 1 ? "DVS128StereoPair" : "DVS128";
    file_.write("#!AER-DAT2.0\r\n# AEChip: " + chip +
                "\r\n# int32 address, int32 time stamp in us, big-endian\r\n");
  }

  void write(std::span<const Event> events) override {
    for (const Event& event : events) {
      check_writable(event, size_, cameras_, file_.path());
      const auto stamp = static_cast<std::uint32_t>(event.t_us & 0xffffffff);
      if (time_.extend(static_cast<std::int32_t>(stamp)) != event.t_us) {
        throw InputError(file_.path().string(), "an event at " + std::to_string(event.t_us) + " us",
                         "time stamps that AEDAT 2.0 holds: from i32, with silences of less than 536 s");
      }
      const auto x = static_cast<std::uint32_t>(size_.width - 1 - event.x);
      const auto y = static_cast<std::uint32_t>(size_.height - 1 - event.y);
      std::array<char, record_bytes> record;
      const std::uint32_t address = davis_ ? Davis::address(x, y, event.on) : Dvs128::address(x, y, event.on);
      put_big_endian(event.camera == 1 ? address | StereoPair::right : address, record.data());
      put_big_endian(stamp, record.data() + 4);
      file_.write(std::as_bytes(std::span(record)));
    }
  }

  void commit() override { file_.commit(); }

 private:
  OutputFile file_;
  ImageSize size_;
  int cameras_;
  bool davis_;
  TimeUnwrapper time_;
};

}  // namespace

std::unique_ptr<EventReader> open_aedat2(InputFile file, const EventReadOptions& options) {
  return std::make_unique<Aedat2Reader>(std::move(file), options);
}

std::unique_ptr<EventWriter> create_aedat2(const std::filesystem::path& path, ImageSize image_size,
                                           int cameras) {
  if (cameras > 1 && image_size != dvs128_size) {
    throw InputError(path.string(), "two cameras of " + text_of(image_size),
                     "128x128 for two cameras in AEDAT 2.0, or a .csv file");
  }
  if (!davis_largest.contains(image_size.width - 1, image_size.height - 1)) {
    throw InputError(path.string(), "an image of " + text_of(image_size),
                     "at most " + text_of(davis_largest) + " for AEDAT 2.0");
  }
  return std::make_unique<Aedat2Writer>(path, image_size, cameras);
}

}  // namespace saccade
