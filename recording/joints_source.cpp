#include "recording/joints_source.h"

#include <cerrno>
#include <cmath>
#include <fstream>
#include <limits>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "core/error.h"
#include "core/units.h"
#include "recording/codec.h"
#include "recording/event_columns.h"
#include "recording/number_text.h"

namespace saccade {
namespace {

constexpr std::size_t longest_line = 4096;

std::ifstream open_text(const std::filesystem::path& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error))
    throw InputError(path.string(), "a directory", "a file of joints");
  std::ifstream file(path, std::ios::binary);
  if (!file) throw InputError(path.string(), std::generic_category().message(errno), "a file of joints");
  return file;
}

std::vector<std::string_view> words_of(std::string_view line) {
  constexpr std::string_view blanks = " \t\r";
  std::vector<std::string_view> words;
  for (;;) {
    const std::size_t begin = line.find_first_not_of(blanks);
    if (begin == std::string_view::npos) return words;
    line.remove_prefix(begin);
    const std::size_t end = std::min(line.find_first_of(blanks), line.size());
    words.push_back(line.substr(0, end));
    line.remove_prefix(end);
  }
}

class HeadLog {
 public:
  HeadLog(const std::filesystem::path& path, std::int64_t host_ahead_us)
      : name_(path.string()), in_(open_text(path)), host_ahead_us_(host_ahead_us) {}

  std::optional<JointsRow> next() {
    std::string line;
    do {
      if (!std::getline(in_, line)) return std::nullopt;
      if (++line_number_ == 1) line = std::string(without_mark(line));
    } while (words_of(line).empty());
    return row_of(line);
  }

 private:
  JointsRow row_of(const std::string& line) {
    const std::vector<std::string_view> words = words_of(line);
    const std::size_t stamps = words.size() - std::min<std::size_t>(words.size(), 1 + head_joint_count);
    std::int64_t number = 0;
    if (line.size() > longest_line || stamps < 1 || stamps > 2 || !parse_number(words[0], number)) fail(line);
    JointsRow row;
    for (std::size_t i = 1; i <= stamps; ++i) {
      const auto time_us = to_us(words[i], TimeUnit::s);
      if (!time_us) fail(line);
      row.t_us = *time_us;
    }
    row.t_us -= host_ahead_us_;
    for (std::size_t i = 0; i < head_joint_count; ++i) {
      double position_deg = 0.0;
      if (!parse_number(words[1 + stamps + i], position_deg) || !std::isfinite(position_deg)) fail(line);
      row.position_rad[torso_joint_count + static_cast<int>(i)] = position_deg * rad_per_deg;
    }
    if (row.t_us < last_us_)
      throw InputError(place(), "a time before that of the last line", "lines sorted by time");
    last_us_ = row.t_us;
    return row;
  }

  [[nodiscard]] std::string place() const { return name_ + ":" + std::to_string(line_number_); }
  [[noreturn]] void fail(const std::string& line) const {
    throw InputError(place(), printable(line.substr(0, 80)),
                     "the number of a packet, one or two times in s, and six joints in degrees");
  }

  std::string name_;
  std::ifstream in_;
  std::size_t line_number_ = 0;
  std::int64_t host_ahead_us_;
  std::int64_t last_us_ = std::numeric_limits<std::int64_t>::min();
};

}  // namespace

bool is_head_log(const std::filesystem::path& path) {
  const int first = open_text(path).peek();
  return (first >= '0' && first <= '9') || first == ' ' || first == '\t';
}

JointsSource open_head_log(const std::filesystem::path& path, std::int64_t host_ahead_us) {
  return JointsSource([log = std::make_shared<HeadLog>(path, host_ahead_us)] { return log->next(); });
}

JointsSource joints_from(JointsSource joints, std::int64_t t_us) {
  struct From {
    JointsSource joints;
    std::int64_t t_us;
    bool begun = false;
    std::optional<JointsRow> ahead = std::nullopt;  // the row after the one that was returned first
  };
  return JointsSource([from = std::make_shared<From>(From{std::move(joints), t_us})] {
    if (!from->begun) {
      from->begun = true;
      std::optional<JointsRow> first = from->joints.next();
      if (!first) return first;
      for (from->ahead = from->joints.next(); from->ahead && from->ahead->t_us <= from->t_us;
           from->ahead = from->joints.next())
        first = from->ahead;
      return first;
    }
    if (from->ahead) return std::exchange(from->ahead, std::nullopt);
    return from->joints.next();
  });
}

}  // namespace saccade
