#pragma once

#include <array>
#include <charconv>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "external/line_process.h"

namespace saccade {

/// Words and numbers in the lines that programs of one's own exchange with us.

/// Appends the shortest text that reads back as the same number.
template <class Number>
void append(std::string& text, Number value) {
  std::array<char, 32> digits;
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
  text.append(digits.data(), end);
}
/// The same after a space.
template <class Number>
void append_word(std::string& text, Number value) {
  text += ' ';
  append(text, value);
}

/// The next word of the line, which is shortened by it; empty at the end.
[[nodiscard]] std::string_view next_word(std::string_view& line);
/// The next word as a finite number; none where it is not one.
[[nodiscard]] std::optional<double> next_number(std::string_view& line);

/// A line of a program in a message: `...`, shortened to 80 letters.
[[nodiscard]] std::string shown(std::string_view line);

[[nodiscard]] std::chrono::milliseconds milliseconds(double seconds);

/// A simulated time in a message: "at 0.2 s".
[[nodiscard]] std::string moment_of(std::int64_t t_us);

/// Ends the program after an exchange whose status is not ok, within about 20 ms, and returns why: "mine gave no answer at 0.2
/// s within 200 ms". `moment`: "at 0.2 s".
[[nodiscard]] std::string end_program(LineProcess& process, LineProcess::Status status,
                                      const std::string& name, const std::string& moment,
                                      std::chrono::milliseconds limit);

/// Where the answer is `failed REASON`, ends the program and returns what it says: "mine failed at its start: REASON".
[[nodiscard]] std::optional<std::string> stated_failure(LineProcess& process, std::string_view answer,
                                                        const std::string& name, const std::string& moment);

}  // namespace saccade
