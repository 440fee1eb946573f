#include "recording/yarp_log_codec.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>

#include "core/error.h"
#include "recording/byte_order.h"
#include "recording/codec.h"
#include "recording/input_file.h"
#include "recording/number_text.h"
#include "recording/output_file.h"
#include "recording/yarp_codec.h"

namespace saccade {
namespace {

constexpr std::size_t longest_word = 64;
/// A list of more is taken in pieces.
constexpr std::size_t most_words = 1 << 14;
constexpr std::size_t most_bytes = 64 << 20;
/// Of the host's clock, in 2096: in 64 bits there is room for ns of that.
constexpr double latest_s = 4e9;
/// How much of a log is looked at to guess its codec.
constexpr std::size_t sample_words = 1 << 12;
constexpr std::size_t sample_packets = 256;
constexpr std::string_view vision_type = "AE";
constexpr std::string_view type_key = "Type: ", codec_key = "Codec: ", size_key = "Size: ",
                           bits_key = "Bits: ", origin_key = "Origin: ";

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }
bool is_digit(std::optional<char> c) { return c >= '0' && c <= '9'; }
bool ends_word(char c) { return is_blank(c) || c == '\n' || c == '(' || c == ')'; }

// ---- the info file -------------------------------------------------------------------------------

std::filesystem::path info_file_of(const std::filesystem::path& log) {
  const std::string name = log.filename().string();
  if (name == "data.log" || name == "binaryevents.log") return log.parent_path() / "info.log";
  return log.parent_path() / (log.stem().string() + ".info.log");
}

/// What stands behind `key` in the info file of a log, up to the semicolon; empty where it has no such line.
std::string info_of(const std::filesystem::path& log, std::string_view key) {
  constexpr int most_lines = 100;
  std::ifstream in(info_file_of(log));
  std::string line;
  for (int i = 0; i < most_lines && std::getline(in, line); ++i) {
    if (!line.starts_with(key)) continue;
    line.erase(0, key.size());
    line.erase(std::min(line.find(';'), line.size()));
    return line;
  }
  return {};
}

/// The number behind `key`, at most `largest` either way; `otherwise` where there is no such line.
std::int64_t number_from_info(const std::filesystem::path& log, std::string_view key, std::int64_t largest,
                              std::int64_t otherwise) {
  const std::string text = info_of(log, key);
  if (text.empty()) return otherwise;
  std::int64_t number = 0;
  if (!parse_number(text, number) || number > largest || number < -largest) {
    throw InputError(info_file_of(log).string(), std::string(key) + printable(text),
                     "a whole number of at most " + std::to_string(largest));
  }
  return number;
}

std::optional<ImageSize> size_from_info(const std::filesystem::path& log) {
  const std::string text = info_of(log, size_key);
  if (text.empty()) return std::nullopt;
  const std::optional<ImageSize> size = parse_size(text);
  if (!size || size->width < 1 || size->height < 1) {
    throw InputError(info_file_of(log).string(), std::string(size_key) + printable(text), "WIDTHxHEIGHT");
  }
  return size;
}

// ---- packets -------------------------------------------------------------------------------------

/// The packets of a log one after the other.
class PacketSource {
 public:
  virtual ~PacketSource() = default;
  /// The next packet with words of vision; false at the end. Where the content is broken an InputError, at each
  /// further call too; words of a list that come before that place have come as a packet by then.
  virtual bool next(YarpPacket& packet) = 0;
  [[nodiscard]] virtual std::int64_t others() const = 0;  ///< lists and packets that were not of vision
  [[nodiscard]] virtual std::string name() const = 0;
};

class TextPackets final : public PacketSource {
 public:
  explicit TextPackets(InputFile file) : file_(std::move(file)) {}

  bool next(YarpPacket& packet) override {
    packet.words.clear();
    if (failure_) throw InputError(*failure_);
    try {
      return take_packet(packet);
    } catch (const InputError& error) {
      failure_ = error;
    }
    packet.words.resize(packet.words.size() / 2 * 2);
    if (packet.words.empty()) throw InputError(*failure_);
    return true;
  }
  std::int64_t others() const override { return others_; }
  std::string name() const override { return file_.name(); }

 private:
  bool take_packet(YarpPacket& packet) {
    if (!find_words()) return false;
    packet.host_s = host_s_;
    packet.host_us = host_us_;
    packet.duration_us = duration_us_;
    packet.of_bytes = !in_list_;
    if (in_list_) {
      take_pairs(packet.words);
    } else {
      take_bytes(packet.words);
    }
    return true;
  }

  /// Goes on to the next pair of numbers in a list of events (`in_list_`), or to the quote of a packet of bytes; false
  /// at the end of the file.
  bool find_words() {
    for (;;) {
      const std::optional<char> next = look();
      if (in_list_ && next == ')') {
        file_.skip(1);
        in_list_ = false;
      } else if (in_list_) {
        return true;
      } else if (next == '\n') {
        end_line();
      } else if (!next) {
        if (line_is_empty_) fail("the end of the file", "the rest of a packet");
        return false;
      } else if (before_line_) {
        begin_line();
      } else if (begin_data()) {
        return true;
      }
    }
  }

  void begin_line() {
    (void)integer("the number of a packet");
    do {
      const std::string_view text = word();
      if (!parse_number(text, host_s_) || !parse_seconds(text, host_us_) ||
          !(host_s_ >= 0.0 && host_s_ < latest_s)) {
        fail(text, "a time in s");
      }
    } while (is_digit(look()));
    before_line_ = false;
    line_is_empty_ = true;
  }

  void end_line() {
    file_.skip(1);
    ++line_number_;
    before_line_ = true;
    line_is_empty_ = false;
  }

  /// The type and what opens its data; whether a quote with vision behind it is ahead.
  bool begin_data() {
    const bool vision = word() == vision_type;
    line_is_empty_ = false;
    if (is_digit(look())) {
      duration_us_ = integer("a duration in us");
      if (look() != '"') fail(found(), "a packet's bytes in quotes");
      if (!vision) {
        std::vector<std::uint32_t> words;
        take_bytes(words);
        ++others_;
      }
      return vision;
    }
    if (look() != '(') fail(found(), "a list in brackets, or a duration and bytes in quotes");
    file_.skip(1);
    in_list_ = vision;
    if (!vision) pass_over_list();
    return false;
  }

  void pass_over_list() {
    for (int depth = 1; depth > 0;) {
      const std::optional<char> next = look();
      if (next == '(' || next == ')') {
        depth += next == '(' ? 1 : -1;
        file_.skip(1);
      } else {
        (void)word();
      }
    }
    ++others_;
  }

  void take_pairs(std::vector<std::uint32_t>& words) {
    while (words.size() < most_words && look() != ')') {
      words.push_back(static_cast<std::uint32_t>(
          integer("a time stamp of -2^31 to 2^31 - 1", std::numeric_limits<std::int32_t>::min())));
      words.push_back(static_cast<std::uint32_t>(integer("an address of 0 to 2^31 - 1")));
    }
  }

  void take_bytes(std::vector<std::uint32_t>& words) {
    bytes_.clear();
    file_.skip(1);  // the quote
    for (bool escaped = false;;) {
      const std::string_view ahead = file_.peek(1);
      if (ahead.empty()) fail("the end of the file", "the rest of a packet");
      std::size_t i = 0;
      for (; i < ahead.size() && (escaped || ahead[i] != '"'); ++i) {
        const char c = ahead[i];
        if (!escaped && c == '\\') {
          escaped = true;
          continue;
        }
        bytes_ += !escaped ? c : c == '0' ? '\0' : c == 'n' ? '\n' : c == 'r' ? '\r' : c;
        escaped = false;
      }
      const bool closed = i < ahead.size();
      file_.skip(closed ? i + 1 : i);
      if (bytes_.size() > most_bytes) fail("more than 64 MiB in quotes", "packets of at most 64 MiB");
      if (closed) break;
    }
    if (bytes_.size() % 4 != 0) {
      fail(std::to_string(bytes_.size()) + " bytes in quotes", "words of 4 bytes");
    }
    for (std::size_t i = 0; i < bytes_.size(); i += 4)
      words.push_back(load_little<std::uint32_t>(bytes_.data() + i));
  }

  std::int64_t integer(std::string_view expectation, std::int64_t smallest = 0) {
    const std::string_view text = word();
    std::int64_t value = 0;
    const bool is_number = parse_number(text, value);
    if (!is_number || value < smallest || value > std::numeric_limits<std::int32_t>::max())
      fail(text, expectation);
    return value;
  }

  /// The first character ahead that is not blank; none at the end of the file.
  std::optional<char> look() {
    for (;;) {
      const std::string_view ahead = file_.peek(1);
      if (ahead.empty()) return std::nullopt;
      const auto it = std::find_if_not(ahead.begin(), ahead.end(), is_blank);
      file_.skip(static_cast<std::size_t>(it - ahead.begin()));
      if (it != ahead.end()) return *it;
    }
  }

  /// Takes the word ahead; the text is valid until the file is looked at again.
  std::string_view word() {
    (void)look();
    const std::string_view ahead = file_.peek(longest_word + 1).substr(0, longest_word + 1);
    const auto end = std::find_if(ahead.begin(), ahead.end(), ends_word);
    const auto length = static_cast<std::size_t>(end - ahead.begin());
    if (length == ahead.size() && length <= longest_word) fail("the end of the file", "the rest of a packet");
    if (length == ahead.size()) fail(ahead, "words of at most " + std::to_string(longest_word) + " letters");
    if (length == 0) fail(found(), "a word or a number");
    file_.skip(length);
    return ahead.substr(0, length);
  }

  /// What is ahead, for a message.
  std::string found() {
    const std::optional<char> next = look();
    if (!next) return "the end of the file";
    return next == '\n' ? "the end of the line" : std::string(1, *next);
  }

  [[noreturn]] void fail(std::string_view value, std::string_view expectation) const {
    throw InputError(file_.name() + ":" + std::to_string(line_number_), printable(value),
                     std::string(expectation));
  }

  InputFile file_;
  double host_s_ = 0.0;
  std::int64_t host_us_ = 0;
  std::int64_t duration_us_ = 0;
  bool before_line_ = true;
  bool line_is_empty_ = false;  ///< no packet behind its times yet
  bool in_list_ = false;
  std::uint64_t line_number_ = 1;
  std::int64_t others_ = 0;
  std::string bytes_;
  std::optional<InputError> failure_;
};

class BinaryPackets final : public PacketSource {
 public:
  explicit BinaryPackets(InputFile file) : file_(std::move(file)) {}

  bool next(YarpPacket& packet) override {
    const std::string_view ahead = file_.peek(pair_bytes);
    const std::size_t pairs = std::min(ahead.size() / pair_bytes, most_words / 2);
    if (pairs == 0 && !ahead.empty()) {
      throw InputError(file_.name() + ": byte " + std::to_string(file_.offset()),
                       "the end of the file inside a pair", "pairs of a stamp and an address, 8 bytes");
    }
    packet.words.clear();
    packet.host_s = std::numeric_limits<double>::quiet_NaN();
    for (std::size_t i = 0; i < 2 * pairs; ++i)
      packet.words.push_back(load_little<std::uint32_t>(ahead.data() + 4 * i));
    file_.skip(pairs * pair_bytes);
    return pairs > 0;
  }
  std::int64_t others() const override { return 0; }
  std::string name() const override { return file_.name(); }

 private:
  static constexpr std::size_t pair_bytes = 8;
  InputFile file_;
};

// ---- events --------------------------------------------------------------------------------------

class YarpLogReader final : public EventReader {
 public:
  YarpLogReader(std::unique_ptr<PacketSource> source, std::string_view kind, const EventReadOptions& options)
      : source_(std::move(source)), kind_(kind) {
    const std::filesystem::path path = source_->name();
    const std::string told = info_of(path, codec_key);
    if (options.yarp_codec != "auto") {
      codec_ = yarp_codec(options.yarp_codec, "codec");
    } else if (!told.empty()) {
      codec_ = yarp_codec(told, info_file_of(path).string());
    } else {
      take_sample();
      codec_ = guess_yarp_codec(sample_);
      guessed_ = true;
    }
    ns_per_tick_ = tick_ns(codec_.address);
    time_ = StampUnwrapper(ns_per_tick_,
                           static_cast<int>(number_from_info(path, bits_key, 31, codec_.stamp_bits)));
    origin_us_ = number_from_info(path, origin_key, std::int64_t{1} << 60, 0);
    image_size_ = options.image_size;
    if (!image_size_) image_size_ = size_from_info(path);
    if (!image_size_) image_size_ = codec_.image_size;
  }

  std::size_t read(std::vector<Event>& events, std::size_t max_events) override {
    const std::size_t before = events.size();
    try {
      while (events.size() - before < max_events) {
        if (next_event_ == ready_.size() && !decode_packet()) break;
        const std::size_t count =
            std::min(ready_.size() - next_event_, max_events - (events.size() - before));
        const auto first = ready_.begin() + static_cast<std::ptrdiff_t>(next_event_);
        events.insert(events.end(), first, first + static_cast<std::ptrdiff_t>(count));
        next_event_ += count;
      }
    } catch (const InputError&) {
      if (events.size() == before) throw;  // else the broken packet is met again, and told, by the next call
    }
    return events.size() - before;
  }

  std::optional<ImageSize> image_size() const override { return image_size_; }
  std::string format() const override {
    return kind_ + ", codec " + std::string(codec_.name) + (guessed_ ? " (guessed)" : "");
  }
  std::string passed_over() const override {
    std::string text;
    if (skin_events_ > 0) text = std::to_string(skin_events_) + " skin events";
    if (source_->others() > 0) {
      text += (text.empty() ? "" : ", ") + std::to_string(source_->others()) + " lists not AE";
    }
    return text;
  }

 private:
  /// The first packets, to guess from. What is broken is met again when the events before it have been read.
  void take_sample() {
    std::size_t words = 0;
    try {
      YarpPacket packet;
      while (words < sample_words && sample_.size() < sample_packets && source_->next(packet)) {
        words += packet.words.size();
        sample_.push_back(packet);
      }
    } catch (const InputError&) {
    }
  }

  /// Makes the events of one more packet ready; false at the end.
  bool decode_packet() {
    ready_.clear();
    next_event_ = 0;
    if (next_sample_ < sample_.size()) {
      packet_ = std::move(sample_[next_sample_++]);
    } else if (!source_->next(packet_)) {
      return false;
    }
    const std::vector<std::uint32_t>& words = packet_.words;
    if (packet_.of_bytes && !codec_.stamped) {
      for (std::size_t i = 0; i < words.size(); ++i) add(spread_time(i), words[i]);
      return true;
    }
    if (words.size() % 2 != 0) {
      throw InputError(
          source_->name(), "a packet of " + std::to_string(4 * words.size()) + " bytes",
          "stamps and addresses, 8 bytes each, as the codec " + std::string(codec_.name) + " has");
    }
    for (std::size_t i = 0; i < words.size(); i += 2) {
      const std::int64_t ticks = time_.extend(words[i], packet_.host_s);
      add(origin_us_ + us_from_ticks(ticks, ns_per_tick_), words[i + 1]);
    }
    return true;
  }

  /// Of a word without a stamp.
  [[nodiscard]] std::int64_t spread_time(std::size_t i) const {
    const auto count = static_cast<std::int64_t>(packet_.words.size());
    const auto left = count - 1 - static_cast<std::int64_t>(i);
    return packet_.host_us - packet_.duration_us * left / count;
  }

  void add(std::int64_t t_us, std::uint32_t word) {
    if (const std::optional<Event> event = codec_.decode(t_us, word)) {
      ready_.push_back(*event);
    } else {
      ++skin_events_;
    }
  }

  std::unique_ptr<PacketSource> source_;
  std::string kind_;
  YarpCodec codec_;
  bool guessed_ = false;
  std::optional<ImageSize> image_size_;
  std::int64_t ns_per_tick_ = 0;
  StampUnwrapper time_{1, 0};
  std::int64_t origin_us_ = 0;
  std::vector<YarpPacket> sample_;
  std::size_t next_sample_ = 0;
  YarpPacket packet_;
  std::vector<Event> ready_;
  std::size_t next_event_ = 0;
  std::int64_t skin_events_ = 0;
};

// ---- writing -------------------------------------------------------------------------------------

void append_escaped(std::string& text, std::uint32_t word) {
  for (int shift = 0; shift < 32; shift += 8) {
    const char c = static_cast<char>(word >> shift & 0xff);
    if (c == '\0') {
      text += "\\0";
    } else if (c == '\n') {
      text += "\\n";
    } else if (c == '\r') {
      text += "\\r";
    } else {
      if (c == '"' || c == '\\') text += '\\';
      text += c;
    }
  }
}

class YarpLogWriter final : public EventWriter {
 public:
  YarpLogWriter(const std::filesystem::path& path, ImageSize size, int cameras)
      : file_(path), info_(info_file_of(path)), size_(size), cameras_(cameras) {}

  void write(std::span<const Event> events) override {
    for (const Event& event : events) {
      check_writable(event, size_, cameras_, file_.path());
      if (event.t_us < 0 || static_cast<double>(event.t_us) >= latest_s * 1e6) {
        throw InputError(file_.path().string(), "an event at " + std::to_string(event.t_us) + " us",
                         "times from 0 to 4e15 us");
      }
      if (!origin_us_) origin_us_ = event.t_us < counter_us ? 0 : event.t_us;
      if (!packet_.empty() &&
          (packet_.size() == packet_events || std::abs(event.t_us - packet_.front().t_us) >= packet_us)) {
        write_packet();
      }
      packet_.push_back(event);
    }
  }

  void commit() override {
    write_packet();
    // The data player wants the first two lines; the others are for readers like ours.
    std::string info = "Type: Bottle;\n[0.000000] /saccade/AE:o [connected]\n";
    const auto tell = [&](std::string_view key, const auto& value) {
      info.append(key).append(value).append(";\n");
    };
    tell(codec_key, codec_.name);
    tell(size_key, text_of(size_));
    tell(bits_key, std::to_string(stamp_bits));
    tell(origin_key, std::to_string(origin_us_.value_or(0)));
    info_.write(info);
    info_.commit();
    file_.commit();
  }

 private:
  static constexpr std::size_t packet_events = 4096;
  static constexpr std::int64_t packet_us = 1000;
  static constexpr int stamp_bits = 31;
  /// How long the counter runs until it wraps.
  static constexpr std::int64_t counter_us = (std::int64_t{1} << stamp_bits) / 25 * 2;

  void write_packet() {
    if (packet_.empty()) return;
    const std::int64_t host_us = packet_.back().t_us;
    line_.clear();
    append_number(line_, packets_++);
    line_ += ' ';
    append_seconds(line_, host_us);
    line_ += " AE ";
    append_number(line_, std::max<std::int64_t>(host_us - packet_.front().t_us, 1));
    line_ += " \"";
    for (const Event& event : packet_) {
      const std::int64_t ticks = ticks_from_us(event.t_us - *origin_us_, tick_ns(codec_.address));
      const auto stamp = static_cast<std::uint32_t>(ticks & ((std::int64_t{1} << stamp_bits) - 1));
      append_escaped(line_, stamp);
      append_escaped(line_, encode_address(event, codec_.address));
    }
    line_ += "\"\n";
    file_.write(line_);
    packet_.clear();
  }

  OutputFile file_;
  OutputFile info_;
  ImageSize size_;
  int cameras_;
  const YarpCodec& codec_ = yarp_codec("ev2_ts", "codec");
  std::optional<std::int64_t> origin_us_;  ///< when the counter was 0
  std::vector<Event> packet_;
  std::int64_t packets_ = 0;
  std::string line_;
};

/// Takes the letters for which `belongs` is true off the front; whether there were any.
template <class Belongs>
bool take(std::string_view& text, Belongs belongs) {
  const auto end = std::find_if_not(text.begin(), text.end(), belongs);
  const auto length = static_cast<std::size_t>(end - text.begin());
  text.remove_prefix(length);
  return length > 0;
}

bool looks_like_yarp_log(std::string_view start) {
  const auto is_decimal = [](char c) { return is_digit(c) || c == '.'; };
  const auto is_type = [](char c) { return (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_'; };
  if (!take(start, is_digit)) return false;
  bool has_time = false;
  while (take(start, is_blank) && take(start, is_decimal)) has_time = true;
  if (!has_time || !take(start, is_type) || !take(start, is_blank)) return false;
  return start.starts_with('(') || (take(start, is_digit) && take(start, is_blank) && start.starts_with('"'));
}

bool is_yarp_binary(const std::filesystem::path& path) {
  return path.filename() == "binaryevents.log" ||
         (path.extension() == ".log" && info_of(path, type_key) == "Binary");
}

std::unique_ptr<EventWriter> create_yarp_log(const std::filesystem::path& path, ImageSize image_size,
                                             int cameras) {
  if (!is_encodable(image_size, AddressCodec::ev2)) {
    throw InputError(path.string(), "an image of " + text_of(image_size),
                     "at most 2048x1024 for an event-driven log");
  }
  return std::make_unique<YarpLogWriter>(path, image_size, cameras);
}

}  // namespace

RecordingFormat yarp_log_format() {
  RecordingFormat format;
  format.name = "event-driven log";
  format.extensions = {".log"};
  format.file_in_folder = "data.log";
  format.sniff = [](const FileStart& start) {
    return looks_like_yarp_log(start.bytes) ? Match::likely : Match::none;
  };
  format.open = [](InputFile file, const EventReadOptions& options) -> std::unique_ptr<EventReader> {
    return std::make_unique<YarpLogReader>(std::make_unique<TextPackets>(std::move(file)), "event-driven log",
                                           options);
  };
  format.create = create_yarp_log;
  format.companions = [](const std::filesystem::path& path) {
    return std::vector<std::filesystem::path>{info_file_of(path)};
  };
  format.cameras = 2;
  format.reads =
      "version 1: lists AE of every codec, [see below](#event-driven-logs); version 2: packets AE, with or "
      "without a "
      "time stamp in each event";
  format.writes = "version 2 with time stamps, info file beside it";
  format.time =
      "ticks of 80 or 128 ns, to the nearest us; counters of 24 to 31 bits, continued with the host's time; "
      "without "
      "stamps spread over the packet's duration; written: 31 bits of 80 ns and `Origin` in the info file";
  format.axes = "0 is ON; two cameras";
  format.limits = "2048 x 1024, times from 0 on";
  return format;
}

RecordingFormat yarp_binary_format() {
  RecordingFormat format;
  format.name = "event-driven binary dump";
  format.extensions = {".log"};
  format.file_in_folder = "binaryevents.log";
  format.sniff = [](const FileStart& start) {
    return is_yarp_binary(start.path) ? Match::certain : Match::none;
  };
  format.open = [](InputFile file, const EventReadOptions& options) -> std::unique_ptr<EventReader> {
    return std::make_unique<YarpLogReader>(std::make_unique<BinaryPackets>(std::move(file)),
                                           "event-driven binary log", options);
  };
  format.reads = "`binaryevents.log`, or any log with `Type: Binary` in its info file";
  format.time =
      "as event-driven log, without the host's time: no silence longer than half the counter's range";
  format.axes = "0 is ON; two cameras";
  return format;
}

}  // namespace saccade
