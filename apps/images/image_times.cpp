#include <cmath>
#include <fstream>
#include <optional>
#include <string_view>

#include "apps/images/image_sequence.h"
#include "core/error.h"
#include "recording/codec.h"
#include "recording/number_text.h"

namespace saccade::inline v0_1 {
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

}  // namespace

std::vector<ImageTime> read_image_times(const fs::path& path) {
  std::ifstream stream(path);
  if (!stream || fs::is_directory(path)) {
    throw InputError(path.string(), fs::exists(path) ? "a file that cannot be read" : "no such file",
                     "a file of times, one a line");
  }
  std::vector<ImageTime> times;
  std::optional<bool> in_seconds;
  int number = 0;
  for (std::string line; std::getline(stream, line);) {
    ++number;
    const std::vector<std::string_view> fields = fields_of(line);
    if (fields.empty() || fields[0].starts_with('#')) continue;
    ImageTime time;
    time.place = path.string() + ":" + std::to_string(number);
    const auto fail = [&](std::string_view found, std::string expectation) {
      throw InputError(time.place, printable(found), std::move(expectation));
    };
    if (fields.size() > 2) fail(line, "a time, or a time and the name of a file");
    const bool seconds = fields[0].find('.') != std::string_view::npos;
    double value_s = 0.0;
    // A double holds 4e9 s to less than half a microsecond, and differences of such times fit into 64 bits.
    const bool parsed = seconds ? parse_number(fields[0], value_s) && std::abs(value_s) < 4e9
                                : parse_number(fields[0], time.t_us) && time.t_us > -4'000'000'000'000'000 &&
                                      time.t_us < 4'000'000'000'000'000;
    if (!parsed) fail(fields[0], "a time in us, or in seconds with a decimal point, within 4e15 us of 0");
    if (seconds) time.t_us = std::llround(value_s * 1e6);
    if (seconds || time.t_us != 0) {
      if (in_seconds.value_or(seconds) != seconds) {
        fail(fields[0], *in_seconds ? "seconds with a decimal point, as before" : "us, as before");
      }
      in_seconds = seconds;
    }
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
  return times;
}

}  // namespace saccade::inline v0_1
