#include "recording/aedat2_codec.h"

#include <algorithm>
#include <array>
#include <filesystem>

#include "core/error.h"
#include "recording/aedat2_layout.h"
#include "recording/aedat_chip.h"
#include "recording/block_reader.h"
#include "recording/byte_order.h"
#include "recording/codec.h"
#include "recording/davis_samples.h"
#include "recording/input_file.h"
#include "recording/output_file.h"
#include "recording/wrapping_time.h"

namespace saccade {
namespace {

constexpr std::size_t record_bytes = 8;
constexpr std::size_t longest_header_line = 4096;

constexpr ImageSize dvs128_size = aedat_dvs128_size;

void put_big_endian(std::uint32_t value, char* bytes) {
  for (int i = 0; i < 4; ++i) bytes[i] = static_cast<char>(value >> (24 - 8 * i) & 0xff);
}

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

/// The records that are no events.
struct SkippedRecords {
  std::int64_t special = 0;
  std::int64_t aps = 0;
  std::int64_t imu = 0;
  std::int64_t of_other_layouts = 0;

  template <class Layout>
  void count(std::uint32_t address) {
    if ((address & Layout::unused) != 0) {
      ++of_other_layouts;
    } else if (std::is_same_v<Layout, Davis> && (address & Davis::sample) != 0) {
      ++((address & Davis::imu_sample) == Davis::imu_sample ? imu : aps);
    } else {
      ++special;
    }
  }
};

/// What the records of a file say of its layout: all of them, or those in the buffer where the file is a pipe.
Aedat2Survey survey_of(InputFile& file) {
  Aedat2Survey survey;
  std::error_code error;
  if (!std::filesystem::is_regular_file(file.name(), error)) {
    survey.add(file.peek(record_bytes));
    return survey;
  }
  InputFile whole(file.name());
  if (!whole.discard(file.offset())) return survey;
  while (true) {
    const std::string_view ahead = whole.peek(record_bytes);
    const std::size_t bytes = ahead.size() / record_bytes * record_bytes;
    if (bytes == 0) return survey;
    survey.add(ahead.substr(0, bytes));
    whole.skip(bytes);
  }
}

class Aedat2Reader final : public BlockReader {
 public:
  Aedat2Reader(InputFile file, const EventReadOptions& options, int version)
      : BlockReader(std::move(file)),
        version_(version),
        time_(version == 1 ? unsigned_time() : signed_time()) {
    const bool layout_given = options.aedat2_layout != "auto";
    AedatChip chip = read_header(layout_given);
    if (layout_given && chip.layout != options.aedat2_layout) chip = {options.aedat2_layout, std::nullopt};
    if (version == 1 && chip.layout.empty()) chip.layout = "dvs128";
    std::optional<Aedat2Survey> survey;
    if (chip.layout.empty()) {
      survey = survey_of(file_);
      chip.layout = survey->layout(options.image_size);
      layout_guessed_ = true;
    }
    layout_ = chip.layout;
    if (layout_ == "dvs128" || layout_ == "stereo") {
      size_ = dvs128_size;
    } else if (layout_ != "dvs640" && layout_ != "davis") {
      throw InputError("aedat2_layout", layout_, "one of auto, dvs128, stereo, dvs640, davis");
    } else if (version == 1) {
      throw InputError(file_.name(), "the layout of a " + chip_name(), "one of 16 bits in AEDAT 1.0");
    } else if (chip.size) {
      size_ = *chip.size;
    } else if (options.image_size) {
      size_ = *options.image_size;
    } else if (layout_ == "dvs640") {
      size_ = aedat_dvs640_size;
      size_guessed_ = layout_guessed_;
    } else {
      size_ = guessed_davis_size(survey ? *survey : survey_of(file_));
      size_guessed_ = true;
    }
    others_ = options.others;
    if (others_ != nullptr) samples_.emplace(others_, size_, ranges_);
    const ImageSize largest = layout_ == "dvs640" ? dvs640_largest : davis_largest;
    if (!largest.contains(size_.width - 1, size_.height - 1)) {
      throw InputError(file_.name(), "an image of " + text_of(size_), "at most " + text_of(largest));
    }
  }

  [[nodiscard]] std::optional<ImageSize> image_size() const override { return size_; }
  [[nodiscard]] std::string format() const override {
    const std::string mark = layout_guessed_ ? " (guessed)" : size_guessed_ ? " (size guessed)" : "";
    return "AEDAT " + std::to_string(version_) + ".0 " + chip_name() + mark;
  }
  [[nodiscard]] std::string guess() const override {
    std::string text =
        size_guessed_ ? "the image size " + text_of(size_) + ", from the addresses; --size sets it" : "";
    if (const std::string ranges = ranges_.missing(); samples_ && samples_->has_inertial() && !ranges.empty())
      text += (text.empty() ? "" : "; ") + ("the inertial unit's range of " + ranges + ", jAER's default");
    return text;
  }
  [[nodiscard]] std::string skipped() const override {
    std::string text;
    append_count(text, skipped_.special, "special events");
    append_count(text, skipped_.aps, "APS samples");
    append_count(text, skipped_.imu, "IMU values");
    if (samples_) append_count(text, samples_->incomplete_frames(), "incomplete frames");
    append_count(text, skipped_.of_other_layouts, "records that are no address of a " + chip_name());
    return text;
  }

 protected:
  bool decode(std::span<Event> block, std::size_t& count) override {
    const bool is_stereo = layout_ == "stereo";
    if (version_ == 1) {
      return is_stereo ? decode_as<StereoPair, Record1>(block, count)
                       : decode_as<Dvs128, Record1>(block, count);
    }
    if (layout_ == "davis") return decode_as<Davis, Record2>(block, count);
    if (layout_ == "dvs640") return decode_as<Dvs640, Record2>(block, count);
    return is_stereo ? decode_as<StereoPair, Record2>(block, count)
                     : decode_as<Dvs128, Record2>(block, count);
  }

 private:
  [[nodiscard]] std::string chip_name() const {
    return layout_ == "davis"    ? "DAVIS"
           : layout_ == "stereo" ? "DVS128StereoPair"
           : layout_ == "dvs640" ? "DVS640"
                                 : "DVS128";
  }

  [[nodiscard]] ImageSize guessed_davis_size(const Aedat2Survey& survey) const {
    if (const auto size = survey.davis_size()) return *size;
    throw InputError(file_.name(),
                     "a header without the image size, and addresses of a DAVIS that reach " +
                         text_of(survey.davis_reach()) + " pixels, counted from the bottom right",
                     "--size WIDTHxHEIGHT of the sensor: 240x180, 346x260 or another one");
  }

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
    std::string name;
    constexpr std::string_view chip_key = "# AEChip: ";
    while (const std::size_t length = header_line(line_end)) {
      const std::string_view line = file_.peek(length).substr(0, length - line_end.size());
      if (line.starts_with(chip_key)) {
        name = line.substr(chip_key.size());
        chip = parse_aedat_chip(name);
        if (chip.layout.empty() && !layout_given)
          file_.fail("the chip " + printable(name), "DVS128, DVS640 or a DAVIS, or --layout and --size");
      }
      ranges_.read(line, name);
      file_.skip(length);
    }
    return chip;
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
      const bool is_event = (address & (Layout::no_event | Layout::unused)) == 0;
      const std::int64_t t_us = time_.extend(Record::stamp(record));
      if (!is_event && !takes<Layout>(address, t_us)) skipped_.template count<Layout>(address);
      block[count] = {t_us, mirrored(Layout::x(address), last_x), mirrored(Layout::y(address), last_y),
                      Layout::on(address), Layout::camera(address)};
      count += is_event ? 1 : 0;
    }
    file_.skip(records * Record::bytes);
    return true;
  }

  /// Whether somebody wants a record that is no event.
  template <class Layout>
  bool takes(std::uint32_t address, std::int64_t t_us) {
    if (!samples_ || (address & Layout::unused) != 0) return false;
    if constexpr (std::is_same_v<Layout, Davis>) return samples_->add(address, t_us);
    // The others have triggers alone, without their edge.
    if (!others_->wants_triggers()) return false;
    others_->add(RecordedTrigger{t_us, 0, TriggerKind::unknown, "DVS"});
    return true;
  }

  int version_;
  std::string layout_;
  ImageSize size_;
  bool layout_guessed_ = false;
  bool size_guessed_ = false;
  SkippedRecords skipped_;
  OtherRecords* others_ = nullptr;
  InertialRanges ranges_;
  std::optional<DavisSamples> samples_;
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
      const bool is_first = !started_;
      started_ = true;
      if (time_.extend(static_cast<std::int32_t>(stamp)) != event.t_us) {
        throw InputError(
            file_.path().string(), "an event at " + std::to_string(event.t_us) + " us",
            is_first ? "a first time from -2^31 to 2^31 - 1 us for AEDAT 2.0; " + std::string(zero_time_hint)
                     : "silences of less than 536 s for AEDAT 2.0");
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
  bool started_ = false;
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
  format.reads =
      "DVS128, its stereo pair, DVS640, DAVIS, by the header's `AEChip` or else by the addresses of the "
      "whole "
      "file, [see below](#aedat-20)";
  format.writes = "DVS128, its stereo pair or DAVIS, by image size and number of cameras";
  format.time = "i32 us, continued over wraps at 2^31 or 2^32";
  format.axes = "mirrored in x and y; DVS128 bit 0 is 1 for OFF, DVS640 bit 0 and DAVIS bit 11 are 1 for ON";
  format.limits = "1024 x 512; two cameras of 128 x 128 only; silences below 536 s";
  return format;
}

}  // namespace saccade
