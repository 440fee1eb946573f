#include "recording/evt_codec.h"

#include <algorithm>
#include <bit>

#include "recording/block_reader.h"
#include "recording/byte_order.h"
#include "recording/codec.h"
#include "recording/evt21_decoder.h"
#include "recording/evt2_decoder.h"
#include "recording/evt3_decoder.h"
#include "recording/evt_encoding.h"
#include "recording/input_file.h"
#include "recording/number_text.h"
#include "recording/output_file.h"
#include "recording/prophesee_header.h"
#include "recording/two_cameras.h"
#include "recording/wrapping_time.h"

namespace saccade {
namespace {

/// `word_bytes`, `run` and `counts` are those of the decoder.
template <class Decoder>
class EvtReader final : public BlockReader {
 public:
  /// `rest`: the decoder's arguments behind the offset of the times.
  template <class... Rest>
  EvtReader(InputFile file, const PropheseeHeader& header, const EventReadOptions& options, std::string name,
            Rest... rest)
      : BlockReader(std::move(file)), decoder_(offset_of(header), rest...), name_(std::move(name)) {
    decoder_.triggers().pass_to(options.others, std::filesystem::path(file_.name()).filename().string());
    const std::optional<ImageSize> size = header.image_size();
    image_size_ = size ? size : options.image_size;
  }

  std::optional<ImageSize> image_size() const override { return image_size_; }
  std::string format() const override { return name_; }
  std::string skipped() const override {
    std::string text;
    append_counts(text, decoder_.counts());
    return text;
  }

 protected:
  bool decode(std::span<Event> block, std::size_t& count) override {
    const std::string_view ahead = file_.peek(Decoder::word_bytes);
    if (ahead.empty()) return false;
    if (ahead.size() < Decoder::word_bytes)
      file_.fail("the end of the file inside a word",
                 "words of " + std::to_string(Decoder::word_bytes) + " bytes");
    const EvtStep step = decoder_.run(ahead, block);
    count = step.events;
    file_.skip(step.words * Decoder::word_bytes);
    return true;
  }

 private:
  std::int64_t offset_of(const PropheseeHeader& header) const {
    constexpr std::int64_t largest_read_offset_us = std::int64_t{1} << 62;
    const std::string offset = header.value("time_offset_us");
    std::int64_t offset_us = 0;
    if (!offset.empty() && (!parse_number(offset, offset_us) || offset_us > largest_read_offset_us ||
                            offset_us < -largest_read_offset_us)) {
      file_.fail("the time_offset_us " + printable(offset), "whole us within 2^62");
    }
    return offset_us;
  }

  Decoder decoder_;
  std::string name_;
  std::optional<ImageSize> image_size_;
};

/// The encoding of a RAW file.
struct FoundEncoding {
  EvtEncoding encoding = EvtEncoding::evt3;
  bool guessed = false;
};

FoundEncoding encoding_of(InputFile& file, const PropheseeHeader& header, const EventReadOptions& options) {
  constexpr std::size_t sample_bytes = std::size_t{1} << 16;
  const std::vector<std::string>& names = evt_encoding_names();
  if (options.evt_encoding != "auto") {
    const auto named = std::ranges::find(names, options.evt_encoding);
    if (named == names.end())
      throw InputError("evt_encoding", options.evt_encoding, "one of auto, " + joined(names));
    return {static_cast<EvtEncoding>(named - names.begin()), false};
  }
  const std::string format = header.value("format");
  const std::string version = header.value("evt");
  const std::string name = format.substr(0, format.find(';'));
  const auto is = [&](std::string_view of_format, std::string_view of_evt) {
    return name == of_format || (name.empty() && version == of_evt);
  };
  if (is("EVT3", "3.0")) return {EvtEncoding::evt3, false};
  if (is("EVT2", "2.0")) return {EvtEncoding::evt2, false};
  const auto fits = [&](EvtEncoding encoding) {
    return fits_evt_encoding(file.peek(sample_bytes).substr(0, sample_bytes), encoding);
  };
  if (is("EVT21", "2.1")) {
    if (format.find(";endianness=legacy") != std::string::npos) return {EvtEncoding::evt21_legacy, false};
    if (format.find(";endianness=") != std::string::npos) return {EvtEncoding::evt21, false};
    const bool is_legacy = fits(EvtEncoding::evt21_legacy) && !fits(EvtEncoding::evt21);
    return {is_legacy ? EvtEncoding::evt21_legacy : EvtEncoding::evt21, is_legacy};
  }
  if (name.empty() && version.empty()) {
    const auto guessed = guess_evt_encoding(file.peek(sample_bytes).substr(0, sample_bytes));
    if (guessed) return {*guessed, true};
    throw InputError(file.name(), "a header that names no encoding, and words of none",
                     "a line % evt or % format (RAW), % Version (DAT), or --evt with " + joined(names));
  }
  throw InputError(file.name(),
                   name.empty() ? "the encoding " + printable(version) : "the format " + printable(name),
                   "EVT2, EVT21 or EVT3");
}

std::unique_ptr<EventReader> read_evt(InputFile file, const PropheseeHeader& header,
                                      const EventReadOptions& options) {
  const auto [encoding, guessed] = encoding_of(file, header, options);
  const std::string mark = guessed ? " (guessed)" : "";
  switch (encoding) {
    case EvtEncoding::evt2:
      return std::make_unique<EvtReader<Evt2Decoder>>(std::move(file), header, options, "EVT2" + mark);
    case EvtEncoding::evt21:
      return std::make_unique<EvtReader<Evt21Decoder>>(std::move(file), header, options, "EVT2.1" + mark,
                                                       Evt21Order::little);
    case EvtEncoding::evt21_legacy:
      return std::make_unique<EvtReader<Evt21Decoder>>(std::move(file), header, options,
                                                       "EVT2.1 legacy" + mark, Evt21Order::legacy);
    case EvtEncoding::evt3:
      break;
  }
  return std::make_unique<EvtReader<Evt3Decoder>>(std::move(file), header, options, "EVT3" + mark);
}

/// The header of a written file. `version`: "3.0"; `offset_us` is added to the times.
std::string header_text(const std::string& version, ImageSize image_size, int cameras,
                        std::int64_t offset_us) {
  std::string header = "% evt " + version + "\n% format EVT" + version.substr(0, 1) +
                       ";height=" + std::to_string(image_size.height) +
                       ";width=" + std::to_string(image_size.width) + "\n% geometry " + text_of(image_size) +
                       "\n";
  if (offset_us != 0) header += "% time_offset_us " + std::to_string(offset_us) + "\n";
  if (cameras == 2) header += "% saccade_cameras 2\n";
  return header + "% end\n";
}

constexpr std::int64_t longest_silence_us = std::int64_t{1} << 36;

/// Beyond these no format holds an event's time.
void check_age(const std::filesystem::path& path, std::int64_t t_us, const std::string& encoding) {
  if (t_us > largest_offset_us || t_us < -largest_offset_us)
    throw InputError(path.string(), "an event at " + std::to_string(t_us) + " us",
                     "times within 2^61 us of 0 for " + encoding + "; " + std::string(zero_time_hint));
}

/// Base of the writers: the header comes with the first event, whose time gives it an offset.
class EvtWriter : public EventWriter {
 public:
  void sync() final { file_.sync(); }
  void commit() final {
    if (!begun_) begin(0);
    file_.commit();
  }

 protected:
  /// `version`: "3.0"; `loop_us`: range of the time; `cameras` 2: the header says that the right camera's events are in the file beside it.
  EvtWriter(const std::filesystem::path& path, ImageSize image_size, int cameras, std::string version,
            std::int64_t loop_us)
      : file_(path),
        image_size_(image_size),
        cameras_(cameras),
        version_(std::move(version)),
        loop_us_(loop_us) {}

  void check(std::span<const Event> events) {
    for (const Event& event : events) check_writable(event, image_size_, 1, file_.path());
    if (!begun_ && !events.empty()) begin(events.front().t_us);
  }
  /// Writes what append_little() has added to words_.
  void flush() {
    file_.write(words_);
    words_.clear();
  }
  [[noreturn]] void refuse(std::int64_t t_us, std::string expectation) const {
    throw InputError(file_.path().string(), "an event at " + std::to_string(t_us) + " us",
                     std::move(expectation));
  }

  OutputFile file_;
  std::int64_t offset_us_ = 0;
  std::string words_;

 private:
  void begin(std::int64_t first_us) {
    offset_us_ = first_us & ~(loop_us_ - 1);
    file_.write(header_text(version_, image_size_, cameras_, offset_us_));
    begun_ = true;
  }

  ImageSize image_size_;
  int cameras_;
  std::string version_;
  std::int64_t loop_us_;
  bool begun_ = false;
};

class Evt2Writer final : public EvtWriter {
 public:
  Evt2Writer(const std::filesystem::path& path, ImageSize image_size, int cameras)
      : EvtWriter(path, image_size, cameras, "2.0", std::int64_t{1} << 34) {}

  void write(std::span<const Event> events) override {
    check(events);
    for (const Event& event : events) {
      check_age(file_.path(), event.t_us, "EVT2");
      put_time(event.t_us);
      put(event.on ? 1 : 0, static_cast<std::uint32_t>(event.t_us & 0x3f) << 22 |
                                static_cast<std::uint32_t>(event.x) << 11 | event.y);
    }
    flush();
  }

 private:
  static constexpr const char* jumps =
      "times that EVT2 holds: not before the file's first 4.8 h, across them back by less than 4 s, "
      "silences of less than 19 h";
  static constexpr std::int64_t bridge = std::int64_t{1}
                                         << 25;  ///< upper parts of the time that a jump is cut into

  void put(std::uint32_t type, std::uint32_t value) { append_little(words_, type << 28 | value); }

  void put_time(std::int64_t t_us) {
    const std::int64_t high = (t_us - offset_us_) >> 6;
    if (high == high_) return;
    if (high_ && (high - *high_) << 6 > longest_silence_us) refuse(t_us, jumps);
    while (high_ && high - *high_ > bridge) put_high(*high_ += bridge);
    if (put_high(high) != high) refuse(t_us, jumps);
    high_ = high;
  }

  /// What a reader takes it for.
  std::int64_t put_high(std::int64_t high) {
    put(0x8, static_cast<std::uint32_t>(high & 0xfffffff));
    return read_back_.extend(high & 0xfffffff);
  }

  std::optional<std::int64_t> high_;
  WrappingTime read_back_ = evt2_high();
};

class Evt3Writer final : public EvtWriter {
 public:
  Evt3Writer(const std::filesystem::path& path, ImageSize image_size, int cameras)
      : EvtWriter(path, image_size, cameras, "3.0", std::int64_t{1} << 24) {}

  void write(std::span<const Event> events) override {
    check(events);
    while (!events.empty()) {
      put_time(events.front().t_us);
      if (events.front().y != y_) put(addr_y, events.front().y);
      y_ = events.front().y;
      const std::size_t length = run_length(events);
      put_run(events.first(length));
      events = events.subspan(length);
    }
    flush();
  }

 private:
  static constexpr const char* jumps =
      "times that EVT3 holds: back by less than 4 s, silences of less than 19 h";
  static constexpr std::int64_t bridge = 1024;  ///< upper parts of the time that a jump is cut into
  static constexpr std::size_t group = 32;      ///< pixels of three vectors

  void put(Evt3 type, unsigned value) {
    append_little(words_, static_cast<std::uint16_t>(static_cast<unsigned>(type) << 12 | value));
  }

  void put_time(std::int64_t t_us) {
    if (t_us == t_us_) return;
    check_age(file_.path(), t_us, "EVT3");
    const std::int64_t high = (t_us - offset_us_) >> 12;
    if (!t_us_ || high != high_) {
      if (!t_us_) high_ = high;
      if ((high - high_) << 12 > longest_silence_us) refuse(t_us, jumps);
      while (high - high_ > bridge) put_high(high_ += bridge);
      if (put_high(high) != high) refuse(t_us, jumps);
      high_ = high;
    }
    put(time_low, static_cast<unsigned>(t_us & 0xfff));
    t_us_ = t_us;
  }

  /// What a reader takes it for.
  std::int64_t put_high(std::int64_t high) {
    put(time_high, static_cast<unsigned>(high & 0xfff));
    return read_back_.extend(high & 0xfff);
  }

  /// How many events are of the first one's time, row and polarity, with x ascending.
  static std::size_t run_length(std::span<const Event> events) {
    std::size_t n = 1;
    while (n < events.size() && events[n].t_us == events[0].t_us && events[n].y == events[0].y &&
           events[n].on == events[0].on && events[n].x > events[n - 1].x)
      ++n;
    return n;
  }

  void put_run(std::span<const Event> run) {
    const unsigned on = run.front().on ? 0x800 : 0;
    const auto pixels_from = [&](std::size_t x) {
      const auto behind = [&](const Event& event) { return event.x >= x + group; };
      return static_cast<std::size_t>(std::find_if(run.begin(), run.end(), behind) - run.begin());
    };
    std::size_t next_x = 0;
    bool continued = false;
    while (!run.empty()) {
      // A group of vectors is three words, four with its base; an event of its own is one.
      if (continued && pixels_from(next_x) < 4) continued = false;
      if (!continued && pixels_from(run.front().x) < 5) {
        put(addr_x, on | run.front().x);
        run = run.subspan(1);
        continue;
      }
      if (!continued) {
        next_x = run.front().x;
        put(vect_base_x, on | run.front().x);
      }
      std::uint32_t bits = 0;
      const std::size_t count = pixels_from(next_x);
      for (const Event& event : run.first(count)) bits |= 1u << (event.x - next_x);
      put(vect_12, bits & 0xfff);
      put(vect_12, bits >> 12 & 0xfff);
      put(vect_8, bits >> 24);
      run = run.subspan(count);
      next_x += group;
      continued = true;
    }
  }

  std::optional<std::int64_t> t_us_;
  std::int64_t high_ = 0;
  std::optional<std::uint16_t> y_;
  WrappingTime read_back_ = evt3_high();
};

std::unique_ptr<EventReader> open_evt(InputFile file, const EventReadOptions& options) {
  const PropheseeHeader header(file);
  const std::filesystem::path right = right_camera_file(file.name());
  auto left = read_evt(std::move(file), header, options);
  if (header.value("saccade_cameras") != "2") return left;
  if (!std::filesystem::exists(right)) {
    throw InputError(right.string(), "no such file",
                     "the right camera's events beside those of the left one");
  }
  InputFile other(right);
  const PropheseeHeader other_header(other);
  return merge_cameras(std::move(left), read_evt(std::move(other), other_header, options));
}

template <class Writer>
std::unique_ptr<EventWriter> create_as(const std::filesystem::path& path, ImageSize image_size, int cameras) {
  auto left = std::make_unique<Writer>(path, image_size, cameras);
  if (cameras == 1) return left;
  return split_cameras(std::move(left), std::make_unique<Writer>(right_camera_file(path), image_size, 1));
}

std::unique_ptr<EventWriter> create_evt(const std::filesystem::path& path, ImageSize image_size,
                                        int cameras) {
  constexpr ImageSize largest{2048, 2048};
  const bool is_evt2 = path.stem().extension() == ".evt2";
  if (!largest.contains(image_size.width - 1, image_size.height - 1)) {
    throw InputError(path.string(), "an image of " + text_of(image_size),
                     std::string("at most 2048x2048 for ") + (is_evt2 ? "EVT2" : "EVT3"));
  }
  return is_evt2 ? create_as<Evt2Writer>(path, image_size, cameras)
                 : create_as<Evt3Writer>(path, image_size, cameras);
}

}  // namespace

RecordingFormat prophesee_raw_format() {
  RecordingFormat format;
  format.name = "Prophesee RAW";
  format.extensions = {".raw"};
  format.sniff = [](const FileStart& start) {
    const auto has = [&](std::string_view key) { return start.bytes.find(key) != std::string_view::npos; };
    if (!start.bytes.starts_with('%')) return Match::none;
    if (has("% evt ") || has("% format ")) return Match::certain;
    // Words behind the header are hardly ever text, but a text's comments begin so too.
    return start.is_text() && start.has_line_without('%') ? Match::none : Match::likely;
  };
  format.open = open_evt;
  format.create = create_evt;
  format.companions = [](const std::filesystem::path& path) {
    return std::vector<std::filesystem::path>{right_camera_file(path)};
  };
  format.cameras = 2;
  format.reads =
      "EVT2, EVT2.1 (either order of its halves) and EVT3, by the line `% evt` or `% format`, else by "
      "`--evt` "
      "or by the words";
  format.writes =
      "EVT3, with vectors for rows, or EVT2 where the name ends in `.evt2.raw`; of two cameras the right "
      "one's in a second file, `events_right.raw` "
      "beside "
      "`events.raw`, merged by time when the first one is read";
  format.time =
      "EVT2 and EVT2.1 34, EVT3 24 bits of us, continued over their wraps; written with `% time_offset_us` "
      "in the "
      "header where "
      "the recording begins after 16.8 s";
  format.axes = "top left, 1 is ON";
  format.limits = "2048 x 2048; late by less than 4 s, silences below 19 h";
  return format;
}

}  // namespace saccade
