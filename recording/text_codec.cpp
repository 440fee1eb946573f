#include "recording/text_codec.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/error.h"
#include "recording/codec.h"
#include "recording/input_file.h"
#include "recording/number_text.h"
#include "recording/output_file.h"

namespace saccade::inline v0_1 {
namespace {

constexpr std::size_t longest_line = 4096;
constexpr std::string_view default_columns = "txyp";
constexpr std::string_view columns_with_camera = "txypc";

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

/// The fields of one line; `count` goes on past the ones that are kept.
struct Fields {
  std::array<std::string_view, columns_with_camera.size()> text;
  std::size_t count = 0;

  explicit Fields(std::string_view line) {
    std::size_t i = 0;
    const auto skip_blanks = [&] {
      while (i < line.size() && is_blank(line[i])) ++i;
    };
    bool after_comma = false;
    for (skip_blanks(); i < line.size() || after_comma; skip_blanks()) {
      const std::size_t begin = i;
      while (i < line.size() && !is_blank(line[i]) && line[i] != ',') ++i;
      if (count < text.size()) text[count] = line.substr(begin, i - begin);
      ++count;
      skip_blanks();
      after_comma = i < line.size() && line[i] == ',';
      if (after_comma) ++i;
    }
  }
};

std::string sorted(std::string_view text) {
  std::string letters(text);
  std::sort(letters.begin(), letters.end());
  return letters;
}

bool are_columns(std::string_view letters) {
  return sorted(letters) == sorted(default_columns) || sorted(letters) == sorted(columns_with_camera);
}

class TextReader final : public EventReader {
 public:
  TextReader(InputFile file, const EventReadOptions& options)
      : file_(std::move(file)), columns_(options.columns), image_size_(options.image_size) {
    if (!are_columns(columns_)) {
      throw InputError("columns", columns_,
                       "the letters t, x, y and p, and c for the camera, in the file's order");
    }
  }

  std::size_t read(std::vector<Event>& events, std::size_t max_events) override {
    std::size_t count = 0;
    try {
      for (; count < max_events && peek_line(); skip_line()) {
        if (skips_line()) continue;
        events.push_back(parse());
        ++count;
      }
    } catch (const InputError&) {
      if (count == 0) throw;  // otherwise the next call reads the broken line again and throws
    }
    return count;
  }

  std::optional<ImageSize> image_size() const override { return image_size_; }
  std::string format() const override { return "text"; }
  std::optional<std::uint64_t> broken_record() const override { return file_.offset(); }

 private:
  /// False at the end of the file.
  bool peek_line() {
    const std::string_view ahead = file_.peek(longest_line + 1);
    const std::string_view window = ahead.substr(0, longest_line + 1);
    const std::size_t end = window.find('\n');
    if (end == std::string_view::npos && window.size() > longest_line) {
      fail("a line of more than " + std::to_string(longest_line) + " characters", "an event per line");
    }
    line_ = window.substr(0, end);
    line_bytes_ = std::min(end, window.size() - 1) + 1;
    return !window.empty();
  }

  void skip_line() {
    file_.skip(line_bytes_);
    ++line_number_;
  }

  bool skips_line() {
    const auto start = std::find_if_not(line_.begin(), line_.end(), is_blank);
    if (start == line_.end() || *start == '#') return true;
    const bool is_header = before_first_ && check_column_names();
    before_first_ = false;
    return is_header;
  }

  /// Whether the line names columns; throws where it names them in another order.
  bool check_column_names() {
    const Fields names(line_);
    if (names.count != columns_.size() && names.count != columns_.size() + 1) return false;
    if (names.count > names.text.size()) return false;
    std::string order;
    for (std::string_view name : std::span(names.text).first(names.count)) {
      if (name.starts_with('"')) name.remove_prefix(1);
      if (name.empty() || !is_letter(name.front())) return false;
      order += static_cast<char>(name.front() | 0x20);  // lower case
    }
    if (order == columns_ + "c") columns_ = order;
    if (names.count != columns_.size()) return false;
    if (are_columns(order) && order != columns_) {
      fail("the column order " + order, columns_ + ", as in the option columns");
    }
    return true;
  }

  Event parse() {
    const Fields fields(line_);
    if (fields.count != columns_.size()) {
      fail(std::to_string(fields.count) + (fields.count == 1 ? " field" : " fields"),
           std::to_string(columns_.size()) + " in the order " + columns_);
    }
    Event event;
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      const std::string_view text = fields.text[i];
      switch (columns_[i]) {
        case 't':
          event.t_us = parse_time(text);
          break;
        case 'x':
          event.x = parse_coordinate(text, "x");
          break;
        case 'y':
          event.y = parse_coordinate(text, "y");
          break;
        case 'p':
          event.on = parse_polarity(text);
          break;
        default:
          event.camera = parse_camera(text);
          break;
      }
    }
    return event;
  }

  std::int64_t parse_time(std::string_view text) {
    const bool seconds = text.find('.') != std::string_view::npos;
    std::int64_t t_us = 0;
    if (!(seconds ? parse_seconds(text, t_us) : parse_number(text, t_us))) {
      fail(text, "a time in us, or in seconds with a decimal point", "t");
    }
    if (t_us == 0 && !seconds) return 0;
    if (in_seconds_.value_or(seconds) != seconds) {
      fail(text, *in_seconds_ ? "seconds with a decimal point, as before" : "us, as before", "t");
    }
    in_seconds_ = seconds;
    return t_us;
  }
  std::uint16_t parse_coordinate(std::string_view text, std::string_view column) const {
    std::uint16_t value = 0;
    if (!parse_number(text, value)) fail(text, "a whole number in [0, 65535]", column);
    return value;
  }
  bool parse_polarity(std::string_view text) const {
    if (text != "0" && text != "1" && text != "-1") fail(text, "a polarity 0 or 1, or -1 or 1", "p");
    return text == "1";
  }

  std::uint8_t parse_camera(std::string_view text) const {
    if (text != "0" && text != "1") fail(text, "0, the left camera, or 1, the right one", "camera");
    return text == "1" ? 1 : 0;
  }

  [[noreturn]] void fail(std::string_view value, std::string_view expectation,
                         std::string_view column = {}) const {
    std::string place = file_.name() + ":" + std::to_string(line_number_);
    if (!column.empty()) place += ", column " + std::string(column);
    throw InputError(place, value.empty() ? "nothing" : printable(value), std::string(expectation));
  }

  InputFile file_;
  std::string columns_;
  std::optional<ImageSize> image_size_;
  std::string_view line_;  ///< the line ahead, into the file's buffer
  std::size_t line_bytes_ = 0;
  std::uint64_t line_number_ = 1;
  bool before_first_ = true;
  std::optional<bool> in_seconds_;
};

class TextWriter final : public EventWriter {
 public:
  TextWriter(const std::filesystem::path& path, ImageSize image_size, int cameras)
      : file_(path), image_size_(image_size), cameras_(cameras) {
    file_.write(cameras_ == 1 ? "t_us,x,y,p\n" : "t_us,x,y,p,camera\n");
  }

  void write(std::span<const Event> events) override {
    for (const Event& event : events) {
      check_writable(event, image_size_, cameras_, file_.path());
      line_.clear();
      append_number(line_, event.t_us);
      line_ += ',';
      append_number(line_, event.x);
      line_ += ',';
      append_number(line_, event.y);
      line_ += event.on ? ",1" : ",0";
      if (cameras_ > 1) line_ += event.camera == 1 ? ",1" : ",0";
      line_ += '\n';
      file_.write(line_);
    }
  }

  void sync() override { file_.sync(); }
  void commit() override { file_.commit(); }

 private:
  OutputFile file_;
  ImageSize image_size_;
  int cameras_;
  std::string line_;
};

}  // namespace

RecordingFormat text_format() {
  RecordingFormat format;
  format.name = "text";
  format.extensions = {".csv", ".txt"};
  format.sniff = [](const FileStart& start) {
    return !start.bytes.starts_with("#!AER-DAT") && start.is_text() ? Match::possible : Match::none;
  };
  format.open = [](InputFile file, const EventReadOptions& options) -> std::unique_ptr<EventReader> {
    return std::make_unique<TextReader>(std::move(file), options);
  };
  format.create = [](const std::filesystem::path& path, ImageSize size,
                     int cameras) -> std::unique_ptr<EventWriter> {
    return std::make_unique<TextWriter>(path, size, cameras);
  };
  format.cameras = 2;
  format.reads = "four or five columns, `--columns`";
  format.writes = "`t_us,x,y,p` and with two cameras `camera`";
  format.time = "us, or s with a decimal point, to the nearest us";
  format.axes = "top left, 1 is ON";
  return format;
}

}  // namespace saccade::inline v0_1
