#include "recording/yarp_log_codec.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "recording/address_event.h"
#include "recording/codec.h"
#include "recording/number_text.h"

namespace saccade {
namespace {

constexpr ImageSize atis_size{304, 240};
constexpr std::size_t longest_word = 64;
constexpr double ticks_per_s = 12.5e6;
constexpr std::string_view vision_type = "AE";

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }
bool is_digit(std::optional<char> c) { return c >= '0' && c <= '9'; }
bool ends_word(char c) { return is_blank(c) || c == '\n' || c == '(' || c == ')'; }

/// Continues time stamps over the wraps of a counter of unknown width.
class StampUnwrapper {
 public:
  std::int64_t extend(std::int64_t stamp, double host_s) {
    if (!started_) {
      last_ = stamp;
      last_host_s_ = host_s;
      started_ = true;
    }
    largest_ = std::max(largest_, stamp);
    const std::int64_t step = stamp - last_;
    if (std::abs(step) > longest_lateness) offset_ += wrap(step, (host_s - last_host_s_) * ticks_per_s);
    last_ = stamp;
    last_host_s_ = host_s;
    return offset_ + stamp;
  }

 private:
  static constexpr std::int64_t longest_lateness = std::int64_t{1} << 23;

  /// What to add to a step so that it comes closest to the ticks that went by at the host: nothing, a wrap
  /// forward for a step back, or, for an event that is late, the last wrap back again.
  [[nodiscard]] std::int64_t wrap(std::int64_t step, double elapsed) const {
    std::int64_t best = 0;
    const auto distance = [&](std::int64_t added) {
      return std::abs(static_cast<double>(step + added) - elapsed);
    };
    for (int bits = 24; bits <= 31; ++bits) {
      const std::int64_t range = std::int64_t{1} << bits;
      const bool possible = range > largest_ && (step < 0 || offset_ >= range);
      const std::int64_t added = step < 0 ? range : -range;
      if (possible && distance(added) < distance(best)) best = added;
    }
    return best;
  }

  bool started_ = false;
  std::int64_t last_ = 0;
  std::int64_t largest_ = 0;
  std::int64_t offset_ = 0;
  double last_host_s_ = 0.0;
};

class YarpLogReader final : public EventReader {
 public:
  YarpLogReader(InputFile file, const EventReadOptions& options)
      : file_(std::move(file)), image_size_(options.image_size.value_or(atis_size)) {}

  std::size_t read(std::vector<Event>& events, std::size_t max_events) override {
    std::size_t count = 0;
    try {
      while (count < max_events && !failure_ && find_pair()) {
        const std::int64_t stamp = integer("a time stamp of 0 to 2^31 - 1");
        const std::int64_t address = integer("an address of 0 to 2^31 - 1");
        std::optional<Event> event =
            decode_address(static_cast<std::uint32_t>(address), AddressCodec::atis_24);
        if (!event) {
          ++skin_events_;
          continue;
        }
        event->t_us = us_from_ticks(time_.extend(stamp, host_s_), tick_ns(AddressCodec::atis_24));
        events.push_back(*event);
        ++count;
      }
    } catch (const InputError& error) {
      failure_ = error;
    }
    if (count == 0 && failure_) throw InputError(*failure_);
    return count;
  }

  std::optional<ImageSize> image_size() const override { return image_size_; }
  std::string format() const override { return "event-driven text log, ATIS 24 bit"; }
  std::string passed_over() const override {
    std::string text;
    if (skin_events_ > 0) text = std::to_string(skin_events_) + " skin events";
    if (other_lists_ > 0) text += (text.empty() ? "" : ", ") + std::to_string(other_lists_) + " lists not AE";
    return text;
  }

 private:
  /// Goes on to the next pair of numbers in a list of events; false at the end of the file.
  bool find_pair() {
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
        return false;
      } else if (before_line_) {
        begin_line();
      } else {
        begin_list();
      }
    }
  }

  void begin_line() {
    (void)integer("the number of a packet");
    do {
      const std::string_view text = word();
      if (!parse_number(text, host_s_) || !std::isfinite(host_s_)) fail(text, "a time in s");
    } while (is_digit(look()));
    before_line_ = false;
  }

  void end_line() {
    file_.skip(1);
    ++line_number_;
    before_line_ = true;
  }

  void begin_list() {
    in_list_ = word() == vision_type;
    if (look() != '(') fail(found(), "a list in brackets");
    file_.skip(1);
    if (!in_list_) pass_over_list();
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
    ++other_lists_;
  }

  std::int64_t integer(std::string_view expectation) {
    const std::string_view text = word();
    std::int64_t value = 0;
    const bool is_number = parse_number(text, value);
    if (!is_number || value < 0 || value > std::numeric_limits<std::int32_t>::max()) fail(text, expectation);
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
  ImageSize image_size_;
  StampUnwrapper time_;
  double host_s_ = 0.0;
  bool before_line_ = true;
  bool in_list_ = false;
  std::uint64_t line_number_ = 1;
  std::int64_t skin_events_ = 0;
  std::int64_t other_lists_ = 0;
  std::optional<InputError> failure_;
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

bool looks_like_yarp_log(std::string_view start) {
  const auto is_decimal = [](char c) { return is_digit(c) || c == '.'; };
  const auto is_type = [](char c) { return (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_'; };
  if (!take(start, is_digit)) return false;
  bool has_time = false;
  while (take(start, is_blank) && take(start, is_decimal)) has_time = true;
  return has_time && take(start, is_type) && take(start, is_blank) && start.starts_with('(');
}

std::unique_ptr<EventReader> open_yarp_log(InputFile file, const EventReadOptions& options) {
  return std::make_unique<YarpLogReader>(std::move(file), options);
}

}  // namespace saccade
