#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <optional>
#include <string_view>

#include "core/error.h"
#include "images/image_sequence.h"
#include "recording/codec.h"
#include "recording/number_text.h"
#include "recording/text_header.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;

/// Fields separated by blanks or a comma.
std::vector<std::string_view> fields_of(std::string_view line) {
  std::vector<std::string_view> fields;
  for (std::size_t i = 0; i < line.size();) {
    const auto apart = [&] { return is_blank(line[i]) || line[i] == ','; };
    const std::size_t begin = i;
    while (i < line.size() && !apart()) ++i;
    if (i > begin) fields.push_back(line.substr(begin, i - begin));
    while (i < line.size() && apart()) ++i;
  }
  return fields;
}

/// Why whole times without a unit are hardly us: no camera is that slow. Empty: they may be us.
std::string why_not_us(const std::vector<ImageTime>& times) {
  std::vector<std::int64_t> steps_us;
  for (std::size_t i = 1; i < times.size(); ++i) steps_us.push_back(times[i].t_us - times[i - 1].t_us);
  if (steps_us.empty()) return {};
  const auto middle = steps_us.begin() + std::ssize(steps_us) / 2;
  std::ranges::nth_element(steps_us, middle);
  constexpr std::int64_t slow_us = 1'000'000;
  if (*middle < slow_us) return {};
  return "whole times without a unit, in the median " + std::to_string(*middle) + " apart";
}

}  // namespace

std::vector<ImageTime> read_image_times(const fs::path& path, std::optional<TimeUnit> unit) {
  std::ifstream stream(path);
  if (!stream || fs::is_directory(path)) {
    throw InputError(path.string(), fs::exists(path) ? "a file that cannot be read" : "no such file",
                     "a file of times, one a line");
  }
  std::vector<ImageTime> times;
  std::vector<double> numbers;  // as they stand there
  std::optional<bool> in_seconds;
  int number = 0;
  for (std::string line; std::getline(stream, line);) {
    if (++number == 1) line = std::string(without_mark(line));
    const std::vector<std::string_view> fields = fields_of(line);
    if (fields.empty()) continue;
    const bool is_comment = fields[0].starts_with('#');
    const std::vector<std::string_view> names =
        names_in(std::string_view(line).substr(is_comment ? line.find('#') + 1 : 0));
    const auto named = times.empty() && !names.empty() ? event_column(names[0]) : std::nullopt;
    if (named && named->column == EventColumn::t && !unit) unit = named->unit;
    if (is_comment || (named && named->column == EventColumn::t)) continue;
    ImageTime time;
    time.place = path.string() + ":" + std::to_string(number);
    const auto fail = [&](std::string_view found, std::string expectation) {
      throw InputError(time.place, printable(found), std::move(expectation));
    };
    if (fields.size() > 2) fail(line, "a time, or a time and the name of a file");
    const bool seconds = fields[0].find('.') != std::string_view::npos;
    std::optional<std::int64_t> t_us;
    if (unit || seconds) t_us = to_us(fields[0], unit.value_or(TimeUnit::s));
    if (std::int64_t whole = 0; !unit && !seconds && parse_number(fields[0], whole)) t_us = whole;
    // Differences of such times fit into 64 bits, and a double holds them to less than half a microsecond.
    if (!t_us || *t_us >= longest_plausible_us || *t_us <= -longest_plausible_us) {
      fail(fields[0], unit ? "a time in " + std::string(word_of(*unit)) + " within 4e15 us of 0"
                           : "a time in us, or in seconds with a decimal point, within 4e15 us of 0; others "
                             "need --time-unit");
    }
    time.t_us = *t_us;
    if (!unit && (seconds || time.t_us != 0)) {
      if (in_seconds.value_or(seconds) != seconds) {
        fail(fields[0], *in_seconds ? "seconds with a decimal point, as before" : "us, as before");
      }
      in_seconds = seconds;
    }
    double value = 0.0;
    numbers.push_back(parse_number(fields[0], value) ? value : 0.0);
    if (fields.size() == 2) time.name = fields[1];
    if (!times.empty() && time.t_us <= times.back().t_us) {
      fail(fields[0], "a time after " + std::to_string(times.back().t_us) + " us");
    }
    if (!times.empty() && time.name.empty() != times.back().name.empty()) {
      fail(line, time.name.empty() ? "a time and the name of a file, as before" : "a time alone, as before");
    }
    times.push_back(std::move(time));
  }
  if (times.empty()) throw InputError(path.string(), "no times", "a time per image, one a line");
  if (unit) return times;
  const std::string why = in_seconds.value_or(false) ? why_not_seconds(numbers) : why_not_us(times);
  if (!why.empty()) throw InputError(path.string(), why, std::string(unit_expectation));
  return times;
}

}  // namespace saccade
