#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace saccade {

/// What a number of a time column counts.
enum class TimeUnit : std::uint8_t { s, ms, us, ns };

/// Of the words s, ms, us and ns, the values of `--time-unit`; none for others.
[[nodiscard]] std::optional<TimeUnit> time_unit_of(std::string_view word);
[[nodiscard]] std::string_view word_of(TimeUnit unit);
/// Of any common spelling: "nsec", "Microseconds", "µs"; none for others.
[[nodiscard]] std::optional<TimeUnit> spelled_time_unit(std::string_view word);

/// Times without a stated unit that lie further from 0 are hardly in us: 4e15 us after 1970 is the year 2096.
inline constexpr std::int64_t longest_plausible_us = 4'000'000'000'000'000;
/// For messages about times whose unit is not known.
inline constexpr std::string_view unit_expectation =
    "times whose unit is stated: --time-unit s, ms, us or ns (time_unit in Python)";

/// To the nearest us; none where the result is not within 2^62 us.
[[nodiscard]] std::optional<std::int64_t> to_us(std::int64_t time, TimeUnit unit);
[[nodiscard]] std::optional<std::int64_t> to_us(double time, TimeUnit unit);
/// The same of a decimal number as text, exactly: no double on the way unless there is an exponent. None for other text too.
[[nodiscard]] std::optional<std::int64_t> to_us(std::string_view time, TimeUnit unit);

/// Why the first times of a recording, floating-point numbers without a stated unit, are hardly s: all of them are whole, one
/// is further than 4e9 s from 0, or the median step of ten or more is longer than 1 s. Empty: they may be s.
[[nodiscard]] std::string why_not_seconds(std::span<const double> first);

/// Which member of an event a column is.
enum class EventColumn { t, x, y, p, camera };
inline constexpr std::size_t event_columns = 5;

struct NamedColumn {
  EventColumn column{};
  std::optional<TimeUnit> unit;  ///< of a time, where the name says it
};

/// The column that a field, an array or a column of that name is, in upper or lower case: t, ts, time, timestamp; x, xs; y, ys;
/// p, ps, pol, polarity, on; camera, cam; and their plurals. A unit may follow: "t_us", "timestamp [ns]", "x_px". None for
/// other names.
[[nodiscard]] std::optional<NamedColumn> event_column(std::string_view name);

}  // namespace saccade
