#include "external/line_text.h"

#include <algorithm>
#include <cmath>

namespace saccade {

std::string_view next_word(std::string_view& line) {
  const std::size_t begin = std::min(line.find_first_not_of(" \t\r"), line.size());
  const std::size_t end = std::min(line.find_first_of(" \t\r", begin), line.size());
  const std::string_view word = line.substr(begin, end - begin);
  line.remove_prefix(end);
  return word;
}

std::optional<double> next_number(std::string_view& line) {
  const std::string_view word = next_word(line);
  double value = 0.0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  const bool whole = error == std::errc() && end == word.data() + word.size() && !word.empty();
  return whole && std::isfinite(value) ? std::optional(value) : std::nullopt;
}

std::string shown(std::string_view line) {
  constexpr std::size_t longest = 80;
  std::string text(line.substr(0, longest));
  std::ranges::replace_if(
      text, [](char c) { return c < ' ' || c > '~'; }, '?');
  return "`" + text + (line.size() > longest ? "...`" : "`");
}

std::chrono::milliseconds milliseconds(double seconds) {
  return std::chrono::milliseconds(static_cast<std::int64_t>(std::ceil(seconds * 1e3)));
}

std::string moment_of(std::int64_t t_us) {
  std::string moment = "at ";
  append(moment,
         static_cast<double>(t_us) / 1e6);  // the nearest number to six decimals, which are then all it has
  return moment + " s";
}

std::string end_program(LineProcess& process, LineProcess::Status status, const std::string& name,
                        const std::string& moment, std::chrono::milliseconds limit) {
  // A program that has ended has a status at once; another one is not waited for, since a tick waits here.
  constexpr std::chrono::milliseconds longest_patience(20);
  const bool has_ended = status == LineProcess::Status::ended;
  const std::string end =
      process.end(has_ended ? std::min(longest_patience, limit / 2) : std::chrono::milliseconds(0));
  switch (status) {
    case LineProcess::Status::late:
      return name + " gave no answer " + moment + " within " + std::to_string(limit.count()) + " ms";
    case LineProcess::Status::unasked:
      return name + " answered more than one line before the tick " + moment;
    case LineProcess::Status::endless:
      return name + " answered a line of more than " + std::to_string(LineProcess::longest_line) + " bytes " +
             moment;
    default:
      return name + (end.empty() ? " closed its output " + moment : " ended " + moment + ", " + end);
  }
}

std::optional<std::string> stated_failure(LineProcess& process, std::string_view answer,
                                          const std::string& name, const std::string& moment) {
  constexpr std::string_view word = "failed ";
  if (!answer.starts_with(word)) return std::nullopt;
  process.end(std::chrono::milliseconds(0));
  return name + " failed " + moment + ": " + std::string(answer.substr(word.size()));
}

}  // namespace saccade
