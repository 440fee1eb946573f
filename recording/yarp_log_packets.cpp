#include "recording/yarp_log_packets.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <vector>

#include "core/error.h"
#include "recording/byte_order.h"
#include "recording/codec.h"
#include "recording/event_columns.h"
#include "recording/number_text.h"

namespace saccade {
namespace {

constexpr std::size_t longest_word = 64;
/// A longer list is returned in pieces.
constexpr std::size_t most_words = 1 << 14;
constexpr std::size_t most_bytes = 64 << 20;
constexpr std::string_view camera_type = "AE";

bool is_digit(std::optional<char> c) { return c >= '0' && c <= '9'; }
bool ends_word(char c) { return is_blank(c) || c == '\n' || c == '(' || c == ')'; }

class TextPackets final : public YarpPacketSource {
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
  std::uint64_t packet_begin() const override { return line_begin_; }

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
    line_begin_ = file_.offset();
    (void)integer("the number of a packet");
    do {
      const std::string_view text = word();
      const auto time_us = to_us(text, TimeUnit::s);
      if (!parse_number(text, host_s_) || !time_us || !(host_s_ >= 0.0 && host_s_ < yarp_latest_s))
        fail(text, "a time in s");
      host_us_ = *time_us;
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

  /// Reads the type and the beginning of its data; true where a quote with camera events is ahead.
  bool begin_data() {
    const bool vision = word() == camera_type;
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
    if (!vision) skip_list();
    return false;
  }

  void skip_list() {
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
  bool line_is_empty_ = false;  ///< no packet after its times yet
  bool in_list_ = false;
  std::uint64_t line_number_ = 1;
  std::uint64_t line_begin_ = 0;
  std::int64_t others_ = 0;
  std::string bytes_;
  std::optional<InputError> failure_;
};

class BinaryPackets final : public YarpPacketSource {
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
  std::uint64_t packet_begin() const override { return file_.offset(); }

 private:
  static constexpr std::size_t pair_bytes = 8;
  InputFile file_;
};

/// Takes the letters for which `belongs` is true off the front; whether there were any.
template <class Belongs>
bool take(std::string_view& text, Belongs belongs) {
  const auto end = std::find_if_not(text.begin(), text.end(), belongs);
  const auto length = static_cast<std::size_t>(end - text.begin());
  text.remove_prefix(length);
  return length > 0;
}

}  // namespace

std::unique_ptr<YarpPacketSource> yarp_text_packets(InputFile file) {
  return std::make_unique<TextPackets>(std::move(file));
}

std::unique_ptr<YarpPacketSource> yarp_binary_packets(InputFile file) {
  return std::make_unique<BinaryPackets>(std::move(file));
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

}  // namespace saccade
