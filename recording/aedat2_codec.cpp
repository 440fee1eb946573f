#include "recording/aedat2_codec.h"

#include <algorithm>
#include <array>

#include "core/error.h"
#include "recording/aedat_chip.h"
#include "recording/block_reader.h"
#include "recording/byte_order.h"
#include "recording/codec.h"
#include "recording/input_file.h"
#include "recording/output_file.h"
#include "recording/wrapping_time.h"

namespace saccade::inline v0_1 {
namespace {

constexpr std::size_t record_bytes = 8;
constexpr std::size_t longest_header_line = 4096;

constexpr ImageSize dvs128_size = aedat_dvs128_size;
constexpr ImageSize davis_largest{1024, 512};
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

/// AEDAT 2.0 has 32-bit times that wrap at 2^32, or at 2^31 as some writers do.
WrappingTime signed_time() {
  return {{{-(std::int64_t{1} << 31), std::int64_t{1} << 32}, {0, std::int64_t{1} << 31}},
          std::int64_t{1} << 29,
          std::int64_t{1} << 24};
}
WrappingTime unsigned_time() {
  return {{{0, std::int64_t{1} << 32}}, std::int64_t{1} << 29, std::int64_t{1} << 24};
}

/// The two records: an address, then the time.
struct Record1 {
  static constexpr std::size_t bytes = 6;
  static std::uint32_t address(const char* record) { return load_big<std::uint16_t>(record); }
  static std::int64_t stamp(const char* record) { return load_big<std::uint32_t>(record + 2); }
};
struct Record2 {
  static constexpr std::size_t bytes = 8;
  static std::uint32_t address(const char* record) { return load_big<std::uint32_t>(record); }
  static std::int64_t stamp(const char* record) { return load_big<std::int32_t>(record + 4); }
};

class Aedat2Reader final : public BlockReader {
 public:
  Aedat2Reader(InputFile file, const EventReadOptions& options, int version)
      : BlockReader(std::move(file)),
        version_(version),
        time_(version == 1 ? unsigned_time() : signed_time()) {
    AedatChip chip = read_header(options.aedat2_layout != "auto");
    if (options.aedat2_layout != "auto") chip.layout = options.aedat2_layout;
    const Range seen = version == 1 ? Range{} : first_addresses();
    if (chip.layout.empty()) chip.layout = seen.wide ? "davis" : "dvs128";
    if (chip.layout == "dvs128") {
      size_ = dvs128_size;
    } else if (chip.layout == "stereo") {
      stereo_ = true;
      size_ = dvs128_size;
    } else if (chip.layout == "davis" && version > 1) {
      davis_ = true;
      size_ = chip.size.value_or(options.image_size.value_or(seen.davis_size));
    } else if (chip.layout == "davis") {
      throw InputError(file_.name(), "the layout of a DAVIS", "one of 16 bits in AEDAT 1.0");
    } else {
      throw InputError("aedat2_layout", chip.layout, "one of auto, dvs128, stereo, davis");
    }
    if (!davis_largest.contains(size_.width - 1, size_.height - 1)) {
      throw InputError(file_.name(), "an image of " + text_of(size_), "at most " + text_of(davis_largest));
    }
  }

  std::optional<ImageSize> image_size() const override { return size_; }
  std::string format() const override {
    const std::string chip = davis_ ? "DAVIS" : stereo_ ? "DVS128StereoPair" : "DVS128";
    return "AEDAT " + std::to_string(version_) + ".0 " + chip;
  }

 protected:
  bool decode(std::span<Event> block, std::size_t& count) override {
    if (version_ > 1 && davis_) return decode_as<Davis, Record2>(block, count);
    if (version_ > 1 && stereo_) return decode_as<StereoPair, Record2>(block, count);
    if (version_ > 1) return decode_as<Dvs128, Record2>(block, count);
    return stereo_ ? decode_as<StereoPair, Record1>(block, count) : decode_as<Dvs128, Record1>(block, count);
  }

 private:
  /// Range of the first addresses of a file whose header does not name the sensor.
  struct Range {
    bool wide = false;  ///< more than the 16 bits of a DVS128
    ImageSize davis_size = aedat_davis_sizes.front();
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
    if (cut && ahead.size() < longest_header_line)
      file_.fail("the end of the file", "the rest of the header");
    return 0;
  }

  AedatChip read_header(bool layout_given) {
    const std::string_view first = file_.peek(longest_header_line).substr(0, longest_header_line);
    const std::size_t newline = first.find('\n');
    const std::string_view line_end =
        newline != std::string_view::npos && newline > 0 && first[newline - 1] == '\r' ? "\r\n" : "\n";
    AedatChip chip;
    constexpr std::string_view chip_key = "# AEChip: ";
    while (const std::size_t length = header_line(line_end)) {
      const std::string_view line = file_.peek(length).substr(0, length - line_end.size());
      if (line.starts_with(chip_key)) {
        chip = parse_aedat_chip(line.substr(chip_key.size()));
        if (chip.layout.empty() && !layout_given) {
          file_.fail("the chip " + printable(line.substr(chip_key.size())),
                     "DVS128 or a DAVIS, or the option aedat2_layout");
        }
      }
      file_.skip(length);
    }
    return chip;
  }

  Range first_addresses() {
    Range range;
    const std::string_view ahead = file_.peek(block_events * record_bytes);
    ImageSize needed{1, 1};
    for (std::size_t i = 0; i + record_bytes <= ahead.size(); i += record_bytes) {
      const std::uint32_t address = load_big<std::uint32_t>(ahead.data() + i);
      range.wide = range.wide || address > 0xffff;
      if ((address & Davis::special) != 0) continue;
      needed.width = std::max(needed.width, static_cast<int>(Davis::x(address)) + 1);
      needed.height = std::max(needed.height, static_cast<int>(Davis::y(address)) + 1);
    }
    const auto fits = [&](ImageSize size) { return size.contains(needed.width - 1, needed.height - 1); };
    const auto sensor = std::find_if(aedat_davis_sizes.begin(), aedat_davis_sizes.end(), fits);
    range.davis_size = sensor != aedat_davis_sizes.end() ? *sensor : davis_largest;
    return range;
  }

  template <class Layout, class Record>
  bool decode_as(std::span<Event> block, std::size_t& count) {
    const std::string_view ahead = file_.peek(Record::bytes);
    if (ahead.empty()) return false;
    const std::size_t records = std::min(ahead.size() / Record::bytes, block.size());
    if (records == 0) {
      file_.fail("the end of the file inside a record",
                 "records of " + std::to_string(Record::bytes) + " bytes");
    }
    const auto last_x = static_cast<std::uint32_t>(size_.width - 1);
    const auto last_y = static_cast<std::uint32_t>(size_.height - 1);
    for (std::size_t i = 0; i < records; ++i) {
      const char* record = ahead.data() + i * Record::bytes;
      const std::uint32_t address = Record::address(record);
      const std::uint32_t x = last_x - Layout::x(address);
      const std::uint32_t y = last_y - Layout::y(address);
      const bool special = (address & Layout::special) != 0;
      if (!special && (x > last_x || y > last_y)) {
        file_.skip(i * Record::bytes);
        file_.fail("a pixel outside the image of " + text_of(size_),
                   "pixels inside it, or another image size");
      }
      block[count] = {time_.extend(Record::stamp(record)), static_cast<std::uint16_t>(x),
                      static_cast<std::uint16_t>(y), Layout::on(address), Layout::camera(address)};
      count += special ? 0 : 1;
    }
    file_.skip(records * Record::bytes);
    return true;
  }

  int version_;
  ImageSize size_;
  bool davis_ = false;
  bool stereo_ = false;
  WrappingTime time_;
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

  void sync() override { file_.sync(); }
  void commit() override { file_.commit(); }

 private:
  OutputFile file_;
  ImageSize size_;
  int cameras_;
  bool davis_;
  WrappingTime time_ = signed_time();
};

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

}  // namespace

RecordingFormat aedat1_format() {
  RecordingFormat format;
  format.name = "AEDAT 1.0";
  format.extensions = {".dat", ".aedat"};
  format.sniff = [](const FileStart& start) {
    if (const Match match = start.begins_with("#!AER-DAT1.0"); match != Match::none) return match;
    const std::string_view first_line = start.bytes.substr(0, start.bytes.find('\n'));
    const bool names_version = first_line.find("AER-DAT") != std::string_view::npos;
    const bool fits = start.bytes.starts_with("# ") && !names_version && !start.is_text();
    return fits ? Match::likely : Match::none;
  };
  format.open = [](InputFile file, const EventReadOptions& options) -> std::unique_ptr<EventReader> {
    return std::make_unique<Aedat2Reader>(std::move(file), options, 1);
  };
  format.reads = "DVS128 and jAER's stereo pair of it, 128 x 128";
  format.time = "u32 us, continued over its wraps at 2^32";
  format.axes = "mirrored in x and y, bit 0 is 1 for OFF";
  return format;
}

RecordingFormat aedat2_format() {
  RecordingFormat format;
  format.name = "AEDAT 2.0";
  format.extensions = {".aedat"};
  format.sniff = [](const FileStart& start) { return start.begins_with("#!AER-DAT2.0"); };
  format.open = [](InputFile file, const EventReadOptions& options) -> std::unique_ptr<EventReader> {
    return std::make_unique<Aedat2Reader>(std::move(file), options, 2);
  };
  format.create = create_aedat2;
  format.cameras = 2;
  format.largest_size = davis_largest;
  format.size_of_two = dvs128_size;
  format.reads = "DVS128, its stereo pair, DAVIS, by the header's `AEChip` or else by the addresses";
  format.writes = "the same three, by image size and number of cameras";
  format.time = "i32 us, continued over wraps at 2^31 or 2^32";
  format.axes = "mirrored in x and y; DVS128 bit 0 is 1 for OFF, DAVIS bit 11 is 1 for ON";
  format.limits = "1024 x 512; two cameras of 128 x 128 only; silences below 536 s";
  return format;
}

}  // namespace saccade::inline v0_1
