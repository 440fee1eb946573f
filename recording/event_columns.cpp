#include "recording/event_columns.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "recording/number_text.h"

namespace saccade {
namespace {

constexpr std::int64_t largest_us = std::int64_t{1} << 62;

/// Decimal digits between a unit and the microsecond: 1 s is 10^6 us.
int digits_to_us(TimeUnit unit) {
  constexpr std::array<int, 4> digits = {6, 3, 0, -3};
  return digits[static_cast<std::size_t>(unit)];
}

double us_in(TimeUnit unit) {
  constexpr std::array<double, 4> us = {1e6, 1e3, 1.0, 1e-3};
  return us[static_cast<std::size_t>(unit)];
}

std::string lower_case(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return lower;
}

std::optional<EventColumn> base_column(std::string_view name) {
  using enum EventColumn;
  constexpr std::array<std::pair<std::string_view, EventColumn>, 24> names = {
      {{"t", t},          {"ts", t},          {"time", t},
       {"times", t},      {"timestamp", t},   {"timestamps", t},
       {"time_stamp", t}, {"time_stamps", t}, {"x", x},
       {"xs", x},         {"y", y},           {"ys", y},
       {"p", p},          {"ps", p},          {"pol", p},
       {"pols", p},       {"polarity", p},    {"polarities", p},
       {"on", p},         {"camera", camera}, {"cameras", camera},
       {"cam", camera},   {"cam_id", camera}, {"camera_id", camera}}};
  for (const auto& [known, column] : names) {
    if (name == known) return column;
  }
  return std::nullopt;
}

}  // namespace

std::optional<TimeUnit> time_unit_of(std::string_view word) {
  for (const TimeUnit unit : {TimeUnit::s, TimeUnit::ms, TimeUnit::us, TimeUnit::ns}) {
    if (word == word_of(unit)) return unit;
  }
  return std::nullopt;
}

std::string_view word_of(TimeUnit unit) {
  constexpr std::array<std::string_view, 4> words = {"s", "ms", "us", "ns"};
  return words[static_cast<std::size_t>(unit)];
}

std::optional<TimeUnit> spelled_time_unit(std::string_view word) {
  const std::string lower = lower_case(word);
  std::string_view stem = lower;
  if (stem == "s") return TimeUnit::s;
  for (const std::string_view micro : {"\xc2\xb5s", "\xce\xbcs"}) {
    if (stem == micro) return TimeUnit::us;
  }
  if (stem.size() > 2 && stem.ends_with('s')) stem.remove_suffix(1);
  constexpr std::array<std::pair<std::string_view, TimeUnit>, 17> words = {{{"sec", TimeUnit::s},
                                                                            {"second", TimeUnit::s},
                                                                            {"ms", TimeUnit::ms},
                                                                            {"msec", TimeUnit::ms},
                                                                            {"milli", TimeUnit::ms},
                                                                            {"millisec", TimeUnit::ms},
                                                                            {"millisecond", TimeUnit::ms},
                                                                            {"us", TimeUnit::us},
                                                                            {"usec", TimeUnit::us},
                                                                            {"micro", TimeUnit::us},
                                                                            {"microsec", TimeUnit::us},
                                                                            {"microsecond", TimeUnit::us},
                                                                            {"ns", TimeUnit::ns},
                                                                            {"nsec", TimeUnit::ns},
                                                                            {"nano", TimeUnit::ns},
                                                                            {"nanosec", TimeUnit::ns},
                                                                            {"nanosecond", TimeUnit::ns}}};
  for (const auto& [known, unit] : words) {
    if (stem == known) return unit;
  }
  return std::nullopt;
}

std::optional<std::int64_t> to_us(std::int64_t time, TimeUnit unit) {
  std::int64_t us = time;
  if (unit == TimeUnit::ns) {
    us = time / 1000;
    const std::int64_t rest = time % 1000;
    if (rest >= 500) ++us;
    if (rest <= -500) --us;
  } else if (__builtin_mul_overflow(time, std::llround(us_in(unit)), &us)) {
    return std::nullopt;
  }
  if (us > largest_us || us < -largest_us) return std::nullopt;
  return us;
}

std::optional<std::int64_t> to_us(double time, TimeUnit unit) {
  const double us = std::round(time * us_in(unit));
  if (!(std::abs(us) < static_cast<double>(largest_us))) return std::nullopt;
  return static_cast<std::int64_t>(us);
}

std::optional<std::int64_t> to_us(std::string_view time, TimeUnit unit) {
  if (time.find_first_of("eE") != std::string_view::npos) {
    double value = 0.0;
    if (!parse_number(time, value)) return std::nullopt;
    return to_us(value, unit);
  }
  const bool negative = time.starts_with('-');
  if (negative) time.remove_prefix(1);
  const std::size_t point = std::min(time.find('.'), time.size());
  const std::string_view whole = time.substr(0, point);
  const std::string_view fraction = time.substr(std::min(point + 1, time.size()));
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  if (whole.empty() && fraction.empty()) return std::nullopt;
  if (!std::ranges::all_of(whole, is_digit) || !std::ranges::all_of(fraction, is_digit)) return std::nullopt;
  std::int64_t number = 0;
  if (!whole.empty() && !parse_number(whole, number)) return std::nullopt;
  const int digits = digits_to_us(unit);
  if (digits < 0) {
    const auto us = to_us(number, unit);  // what is behind the point is below half a us
    return us && negative ? std::optional(-*us) : us;
  }
  const auto length = static_cast<std::size_t>(digits);
  auto us = to_us(number, unit);
  if (!us) return std::nullopt;
  std::int64_t micros = 0;
  for (std::size_t i = 0; i < length; ++i)
    micros = micros * 10 + (i < fraction.size() ? fraction[i] - '0' : 0);
  if (fraction.size() > length && fraction[length] >= '5') ++micros;
  return negative ? -(*us + micros) : *us + micros;
}

std::string why_not_seconds(std::span<const double> first) {
  constexpr double longest_s = 1e-6 * static_cast<double>(longest_plausible_us);
  constexpr std::size_t enough = 10;
  const auto in_words = [](double value) {
    std::string text;
    append_number(text, value);
    return text;
  };
  bool all_whole = true;
  double largest = 0.0;
  std::vector<double> steps;
  for (std::size_t i = 0; i < first.size(); ++i) {
    if (!std::isfinite(first[i])) continue;
    all_whole = all_whole && first[i] == std::round(first[i]);
    largest = std::max(largest, std::abs(first[i]));
    if (i > 0) steps.push_back(std::abs(first[i] - first[i - 1]));
  }
  if (largest > longest_s) return "the time " + in_words(largest) + " without a unit";
  if (all_whole && largest > 0.0) return "floating-point times without fractions, up to " + in_words(largest);
  if (steps.size() + 1 < enough) return {};
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::ranges::nth_element(steps, middle);
  if (!(*middle > 1.0)) return {};
  return "times without a unit, in the median " + in_words(*middle) + " apart";
}

std::optional<NamedColumn> event_column(std::string_view name) {
  const auto trimmed = [](std::string_view text, std::string_view what) {
    const std::size_t begin = std::min(text.find_first_not_of(what), text.size());
    text.remove_prefix(begin);
    return text.substr(0, text.find_last_not_of(what) + 1);
  };
  std::string lower = lower_case(trimmed(name, " \t\r\"'"));
  std::optional<TimeUnit> unit;
  // timestamp [ns], t(us)
  const std::size_t bracket = lower.find_first_of("[(");
  if (bracket != std::string::npos && bracket > 0) {
    unit = spelled_time_unit(trimmed(std::string_view(lower).substr(bracket), "[()] \t"));
    lower = trimmed(std::string_view(lower).substr(0, bracket), " \t_");
  }
  const auto named = [&](std::string_view base) -> std::optional<NamedColumn> {
    const auto column = base_column(base);
    if (!column) return std::nullopt;
    return NamedColumn{*column, *column == EventColumn::t ? unit : std::nullopt};
  };
  if (const auto found = named(lower)) return found;
  // t_us, time_in_ns, timestamp-s, x_px
  const std::size_t line = lower.find_last_of("_-. ");
  if (line != std::string::npos) {
    const std::string_view ending = std::string_view(lower).substr(line + 1);
    std::string_view base = std::string_view(lower).substr(0, line);
    if (base.ends_with("_in")) base.remove_suffix(3);
    const auto ending_unit = spelled_time_unit(ending);
    const auto column = base_column(base);
    if (column == EventColumn::t && ending_unit) return NamedColumn{*column, ending_unit};
    const bool is_pixel = column == EventColumn::x || column == EventColumn::y;
    if (is_pixel && (ending == "px" || ending == "pixel")) return NamedColumn{*column, {}};
    return std::nullopt;
  }
  // timeUs, timestampNs
  for (const std::string_view base : {"timestamp", "time"}) {
    if (!lower.starts_with(base)) continue;
    if (const auto ending_unit = spelled_time_unit(std::string_view(lower).substr(base.size())))
      return NamedColumn{EventColumn::t, ending_unit};
  }
  return std::nullopt;
}

}  // namespace saccade
