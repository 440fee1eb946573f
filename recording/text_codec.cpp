#include "recording/text_codec.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/error.h"
#include "recording/codec.h"
#include "recording/input_file.h"
#include "recording/number_text.h"
#include "recording/output_file.h"
#include "recording/text_header.h"
#include "recording/text_source.h"

namespace saccade {
namespace {

constexpr std::size_t longest_text_line = 4096;
constexpr std::size_t sample_bytes = 1
                                     << 15;  ///< from which the unit of the time follows where none is stated
constexpr std::string_view default_columns = "txyp";
constexpr std::string_view columns_behind_geometry = "xypt";  ///< of Prophesee's programs
constexpr std::size_t most_columns = 32;

/// The fields of one line; `count` goes on past the ones that are kept.
struct Fields {
  std::array<std::string_view, most_columns> text;
  std::size_t count = 0;

  explicit Fields(std::string_view line) {
    std::size_t i = 0;
    const auto skip_blanks = [&] {
      while (i < line.size() && is_blank(line[i])) ++i;
    };
    const auto is_separator = [&] { return i < line.size() && (line[i] == ',' || line[i] == ';'); };
    bool after_separator = false;
    for (skip_blanks(); i < line.size() || after_separator; skip_blanks()) {
      const std::size_t begin = i;
      while (i < line.size() && !is_blank(line[i]) && !is_separator()) ++i;
      if (count < text.size()) text[count] = line.substr(begin, i - begin);
      ++count;
      skip_blanks();
      after_separator = is_separator();
      if (after_separator) ++i;
    }
  }
};

/// t, x, y and p once each, c at most once, and any number of _.
bool are_columns(std::string_view letters) {
  const auto count = [&](char letter) { return std::ranges::count(letters, letter); };
  return letters.find_first_not_of("txypc_") == std::string_view::npos && letters.size() <= most_columns &&
         count('t') == 1 && count('x') == 1 && count('y') == 1 && count('p') == 1 && count('c') <= 1;
}

/// Whether a file's columns are those of the option, which may leave out the last ones and skip any.
bool agree(std::string_view option, std::string_view named) {
  if (option.size() > named.size()) return false;
  for (std::size_t i = 0; i < option.size(); ++i) {
    if (option[i] != '_' && option[i] != named[i]) return false;
  }
  return true;
}

bool is_fractional(std::string_view time) { return time.find_first_of(".eE") != std::string_view::npos; }

class TextReader final : public EventReader {
 public:
  TextReader(InputFile file, const EventReadOptions& options)
      : source_(std::move(file)), image_size_(options.image_size), unit_(options.time_unit) {
    const bool ordered = options.columns != EventReadOptions{}.columns;
    if (ordered && !are_columns(options.columns)) {
      throw InputError("columns", options.columns,
                       "the letters t, x, y and p, c for the camera and _ for a column that is not read, in "
                       "the file's order");
    }
    if (ordered) columns_.letters = options.columns;
    read_head(ordered);
    if (!unit_) unit_ = columns_.unit;
    if (!unit_) look_at_times();
    // A first line that is wrong is that of another file; one that is cut off is torn.
    if (peek_event() && !line_is_last_) (void)parse();
  }

  std::size_t read(std::vector<Event>& events, std::size_t max_events) override {
    std::size_t count = 0;
    try {
      for (; count < max_events && peek_event(); skip_line(), ++count) events.push_back(parse());
    } catch (const InputError&) {
      if (count == 0) throw;  // otherwise the next call reads the broken line again and throws
    }
    return count;
  }

  std::optional<ImageSize> image_size() const override { return image_size_; }
  std::string format() const override {
    const std::string text = source_.is_in_zip() ? "text in ZIP" : "text";
    return unit_ && unit_ != TimeUnit::us ? text + ", time in " + std::string(word_of(*unit_)) : text;
  }
  std::string skipped() const override {
    std::string text;
    for (const std::string& name : columns_.unread)
      text += (text.empty() ? "column " : ", column ") + printable(name);
    return text;
  }
  std::optional<std::uint64_t> broken_record() const override { return source_.offset(); }
  bool breaks_inside() const override { return !line_is_last_; }

 private:
  /// False at the end of the file.
  bool peek_line() {
    const std::string_view ahead = source_.peek(longest_text_line + 1);
    const std::string_view window = ahead.substr(0, longest_text_line + 1);
    const std::size_t end = window.find('\n');
    line_is_last_ = end == std::string_view::npos;
    if (line_is_last_ && window.size() > longest_text_line) {
      line_is_last_ = false;
      fail("a line of more than " + std::to_string(longest_text_line) + " characters", "an event per line");
    }
    line_ = window.substr(0, end);
    line_bytes_ = std::min(end, window.size() - 1) + 1;
    return !window.empty();
  }

  /// Goes on to the line of the next event; false at the end of the file.
  bool peek_event() {
    for (; peek_line(); skip_line()) {
      const auto start = std::find_if_not(line_.begin(), line_.end(), is_blank);
      if (start != line_.end() && *start != '#' && *start != '%') return true;
    }
    return false;
  }

  void skip_line() {
    source_.skip(line_bytes_);
    ++line_number_;
  }

  /// Reads the lines in front of the events: comments, the image size, the names of the columns. `ordered`: the option has
  /// their order.
  void read_head(bool ordered) {
    const std::string_view start = source_.peek(3);
    source_.skip(start.size() - without_mark(start).size());
    std::optional<TextColumns> in_comment;
    bool has_names = false;
    for (; peek_line(); skip_line()) {
      std::string_view text = line_;
      text.remove_prefix(std::min(text.find_first_not_of(" \t\r"), text.size()));
      if (text.empty()) continue;
      if (text.front() == '#' || text.front() == '%') {
        if (const auto size = geometry_in_comment(text)) {
          image_size_ = size;
          if (!ordered && !has_names && text.front() == '%') columns_.letters = columns_behind_geometry;
        }
        if (auto named = named_columns_of_comment(text.substr(1))) in_comment = std::move(named);
      } else if (const auto size = has_names || line_is_last_ ? std::nullopt : size_in_line(text)) {
        image_size_ = size;
      } else if (!has_names && is_line_of_names(text)) {
        take_names(text, ordered);
        has_names = true;
      } else {
        break;
      }
    }
    const std::size_t count = line_.empty() ? 0 : Fields(line_).count;
    if (!has_names && in_comment && in_comment->letters.size() == count &&
        (!ordered || agree(columns_.letters, in_comment->letters))) {
      if (!ordered) columns_ = std::move(*in_comment);
      if (ordered) columns_.unit = in_comment->unit;
      has_names = true;
    }
    if (columns_.letters.empty()) columns_.letters = default_columns;
    if (has_names || ordered) return;
    while (columns_.letters.size() < std::min(count, most_columns)) {
      columns_.letters += '_';
      columns_.unread.push_back(std::to_string(columns_.letters.size()) + ", which has no name");
    }
  }

  /// "t x y p" or "columns: t x y p"; none where there are other words.
  static std::optional<TextColumns> named_columns_of_comment(std::string_view text) {
    for (const std::size_t begin : {std::size_t{0}, text.find(':') + 1}) {
      const std::vector<std::string_view> names = names_in(text.substr(begin));
      const bool all_known =
          std::ranges::all_of(names, [](auto name) { return event_column(name).has_value(); });
      if (names.size() >= default_columns.size() && all_known) return named_columns(text.substr(begin));
    }
    return std::nullopt;
  }

  /// Takes the line of the columns' names. Throws where they contradict the option, or leave the order open.
  void take_names(std::string_view line, bool ordered) {
    auto named = named_columns(line);
    if (!named && !ordered) fail("the column names " + std::string(line), std::string(names_expectation));
    if (!named) return;
    if (ordered && !agree(columns_.letters, named->letters))
      fail("the column order " + named->letters, columns_.letters + ", as in the option columns");
    if (!ordered || named->letters.starts_with(columns_.letters)) {
      columns_ = std::move(*named);
    } else {
      columns_.unit = named->unit;
      columns_.letters.resize(named->letters.size(), '_');
    }
  }

  /// Throws where the first times are neither us nor s as far as can be told.
  void look_at_times() {
    const std::size_t place = columns_.letters.find('t');
    std::string_view ahead = source_.peek(sample_bytes).substr(0, sample_bytes);
    std::vector<double> times;
    bool all_fractional = true;
    while (!ahead.empty()) {
      const std::size_t end = ahead.find('\n');
      if (end == std::string_view::npos && ahead.size() > longest_text_line) break;
      const Fields fields(ahead.substr(0, end));
      ahead.remove_prefix(std::min(end, ahead.size() - 1) + 1);
      double time = 0.0;
      if (fields.count != columns_.letters.size() || !parse_number(fields.text[place], time)) continue;
      times.push_back(time);
      all_fractional = all_fractional && (is_fractional(fields.text[place]) || time == 0.0);
    }
    if (!all_fractional) return;
    const std::string why = why_not_seconds(times);
    if (!why.empty()) fail(why, unit_expectation, "t");
  }

  Event parse() {
    const Fields fields(line_);
    const std::string& letters = columns_.letters;
    if (fields.count != letters.size()) {
      fail(std::to_string(fields.count) + (fields.count == 1 ? " field" : " fields"),
           std::to_string(letters.size()) + " in the order " + letters);
    }
    Event event;
    for (std::size_t i = 0; i < letters.size(); ++i) {
      const std::string_view text = fields.text[i];
      switch (letters[i]) {
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
        case 'c':
          event.camera = parse_camera(text);
          break;
        default:
          break;
      }
    }
    return event;
  }

  std::int64_t parse_time(std::string_view text) {
    std::int64_t t_us = 0;
    if (unit_) {
      if (unit_ == TimeUnit::us && parse_number(text, t_us)) return t_us;
      const auto time = to_us(text, *unit_);
      if (!time) fail(text, "a time in " + std::string(word_of(*unit_)), "t");
      return *time;
    }
    const bool seconds = is_fractional(text);
    const auto time = seconds ? to_us(text, TimeUnit::s) : std::nullopt;
    if (seconds ? !time : !parse_number(text, t_us)) {
      fail(text, "a time in us, or in seconds with a decimal point", "t");
    }
    if (time) t_us = *time;
    if (t_us == 0 && !seconds) return 0;
    if (t_us > longest_plausible_us || t_us < -longest_plausible_us) fail(text, unit_expectation, "t");
    if (in_seconds_.value_or(seconds) != seconds) {
      fail(text, *in_seconds_ ? "seconds with a decimal point, as before" : "us, as before", "t");
    }
    in_seconds_ = seconds;
    return t_us;
  }

  std::uint16_t parse_coordinate(std::string_view text, std::string_view column) const {
    std::uint16_t value = 0;
    if (parse_number(text, value)) return value;
    double real = 0.0;  // 3.0, as NumPy writes it
    if (!parse_number(text, real) || !(real >= 0.0 && real <= 65535.0) || real != std::floor(real))
      fail(text, "a whole number in [0, 65535]", column);
    return static_cast<std::uint16_t>(real);
  }

  bool parse_polarity(std::string_view text) const {
    if (text == "1") return true;
    if (text == "0" || text == "-1") return false;
    if (text == "True" || text == "true" || text == "TRUE") return true;
    if (text == "False" || text == "false" || text == "FALSE") return false;
    double real = 0.0;
    if (!parse_number(text, real) || (real != 0.0 && real != 1.0 && real != -1.0))
      fail(text, "a polarity 0 or 1, -1 or 1, or False or True", "p");
    return real == 1.0;
  }

  std::uint8_t parse_camera(std::string_view text) const {
    if (text != "0" && text != "1") fail(text, "0, the left camera, or 1, the right one", "camera");
    return text == "1" ? 1 : 0;
  }

  [[noreturn]] void fail(std::string_view value, std::string_view expectation,
                         std::string_view column = {}) const {
    std::string place = source_.name() + ":" + std::to_string(line_number_);
    if (!column.empty()) place += ", column " + std::string(column);
    throw InputError(place, value.empty() ? "nothing" : printable(value), std::string(expectation));
  }

  static constexpr std::string_view names_expectation =
      "names that say which columns are t, x, y and p; --columns gives the order of others";

  TextSource source_;
  TextColumns columns_;
  std::optional<ImageSize> image_size_;
  std::optional<TimeUnit> unit_;
  std::string_view line_;  ///< the line ahead, into the source's buffer
  std::size_t line_bytes_ = 0;
  bool line_is_last_ = false;  ///< the line ahead has no end
  std::uint64_t line_number_ = 1;
  std::optional<bool> in_seconds_;
};

/// Whether a ZIP file may hold a text: it has no mark of its own.
Match zipped_text_match(const FileStart& start) {
  return start.begins_with(zip_mark) == Match::certain ? Match::likely : Match::none;
}

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
    const bool is_text = !start.bytes.starts_with("#!AER-DAT") && start.is_text();
    return is_text ? Match::possible : zipped_text_match(start);
  };
  format.open = [](InputFile file, const EventReadOptions& options) -> std::unique_ptr<EventReader> {
    return std::make_unique<TextReader>(std::move(file), options);
  };
  format.create = [](const std::filesystem::path& path, ImageSize size,
                     int cameras) -> std::unique_ptr<EventWriter> {
    return std::make_unique<TextWriter>(path, size, cameras);
  };
  format.cameras = 2;
  format.reads =
      "columns of time, x, y and polarity, and of the camera where there is one, in the order of the line of "
      "names or of "
      "`--columns`; comments, a line of the image size, the only text in a ZIP file";
  format.writes = "`t_us,x,y,p` and with two cameras `camera`";
  format.time =
      "in the unit of the column's name (`t_ns`, `timestamp [ns]`) or of `--time-unit`, else us, or s with a "
      "decimal "
      "point; to the nearest us";
  format.axes = "top left, 1 is ON";
  return format;
}

}  // namespace saccade
