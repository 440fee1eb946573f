#include "sim/motion_file.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <optional>
#include <string_view>
#include <vector>

#include "core/error.h"
#include "core/rotation_vector.h"
#include "recording/number_text.h"

namespace saccade {
namespace {

constexpr std::array<std::string_view, 8> column_names = {"t_s", "x_m", "y_m", "z_m", "qw", "qx", "qy", "qz"};
constexpr std::size_t needed_columns = 4;
constexpr std::size_t most_problems = 20;
constexpr double farthest_m = 50.0;
constexpr double norm_tolerance = 0.01;
constexpr const char* header_expectation =
    "a header with the columns t_s,x_m,y_m,z_m or t_s,x_m,y_m,z_m,qw,qx,qy,qz (metres; orientations as unit "
    "quaternions, not as "
    "angles)";

std::string_view trimmed(std::string_view text) {
  const auto is_blank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

std::vector<std::string_view> cells_of(std::string_view line) {
  std::vector<std::string_view> cells;
  for (std::size_t begin = 0;;) {
    const std::size_t end = std::min(line.find(',', begin), line.size());
    cells.push_back(trimmed(line.substr(begin, end - begin)));
    if (end == line.size()) return cells;
    begin = end + 1;
  }
}

std::optional<double> number_of(std::string_view cell) {
  if (cell.starts_with('+')) cell.remove_prefix(1);
  double value = 0.0;
  const char* const end = cell.data() + cell.size();
  const auto result = std::from_chars(cell.data(), end, value);
  if (result.ec != std::errc() || result.ptr != end || !std::isfinite(value)) return std::nullopt;
  return value;
}

/// Reads one table; collects what is wrong.
class MotionTableReader {
 public:
  explicit MotionTableReader(const MotionFileConfig& config)
      : config_(config),
        origin_m_(config.origin_m[0], config.origin_m[1], config.origin_m[2]),
        root_from_table_(rotation_of(radians(config.axes_turn_deg))) {}

  MotionTable read() {
    std::ifstream file(config_.file, std::ios::binary);
    std::string line;
    bool has_header = false;
    while (problems_.size() < most_problems && std::getline(file, line)) {
      ++line_;
      const std::string_view text = trimmed(line_ == 1 ? without_mark(line) : line);
      if (text.empty() || text.front() == '#') continue;
      if (has_header) {
        read_row(cells_of(text));
      } else {
        read_header(cells_of(text));
        has_header = true;
      }
    }
    if (line_ == 0) throw InputError(config_.file, "", "a readable table of a motion");
    if (!has_header) add("", "no header", header_expectation);
    if (problems_.empty() && samples_.size() < 2) {
      add("", std::to_string(samples_.size()) + " rows", "at least two rows");
    }
    if (!problems_.empty()) throw InputError(problems_);
    return {turns_, MotionTrack(std::move(samples_))};
  }

 private:
  void add(std::string_view column, std::string found, std::string expectation) {
    std::string place = config_.file + ":" + std::to_string(line_);
    if (!column.empty()) place += ": " + std::string(column);
    problems_.push_back({std::move(place), std::move(found), std::move(expectation)});
  }

  void read_header(const std::vector<std::string_view>& names) {
    for (std::size_t i = 0; i < names.size(); ++i) {
      const auto known = std::find(column_names.begin(), column_names.end(), names[i]);
      const std::size_t column = static_cast<std::size_t>(known - column_names.begin());
      if (known == column_names.end() || place_[column]) {
        throw_header(known == column_names.end() ? "the column \"" + std::string(names[i]) + "\""
                                                 : "the column " + std::string(names[i]) + " twice");
      }
      place_[column] = i;
    }
    turns_ = names.size() > needed_columns;
    for (std::size_t column = 0; column < (turns_ ? column_names.size() : needed_columns); ++column) {
      if (!place_[column]) throw_header("no column " + std::string(column_names[column]));
    }
    columns_ = names.size();
  }

  [[noreturn]] void throw_header(std::string found) {
    add("", std::move(found), header_expectation);
    throw InputError(problems_);
  }

  void read_row(const std::vector<std::string_view>& cells) {
    if (cells.size() != columns_) {
      add("", std::to_string(cells.size()) + " cells", std::to_string(columns_) + " cells, as in the header");
      return;
    }
    std::array<double, column_names.size()> values{};
    bool whole = true;
    for (std::size_t column = 0; column < columns_; ++column) {
      const std::string_view cell = cells[*place_[column]];
      if (const auto value = number_of(cell)) {
        values[column] = *value;
      } else {
        add(column_names[column], cell.empty() ? "an empty cell" : "\"" + std::string(cell) + "\"",
            "a finite number");
        whole = false;
      }
    }
    if (whole) add_sample(values);
  }

  void add_sample(const std::array<double, column_names.size()>& values) {
    const double t_s = values[0];
    if (last_line_ > 0) check_time(t_s);
    if (last_line_ == 0) first_s_ = t_s;
    last_line_ = line_;
    last_s_ = t_s;
    MotionSample sample;
    sample.t_s = t_s - first_s_;
    sample.position_m = origin_m_ + root_from_table_ * Eigen::Vector3d(values[1], values[2], values[3]);
    if (!(sample.position_m.cwiseAbs().maxCoeff() <= farthest_m)) {
      add("", "a position " + text_of(std::round(sample.position_m.norm())) + " m from the root",
          "positions in metres, at most " + text_of(farthest_m) + " m from the root along each axis");
    }
    if (turns_) {
      const Eigen::Quaterniond turn(values[4], values[5], values[6], values[7]);
      const double norm = turn.norm();
      if (!(std::abs(norm - 1.0) <= norm_tolerance)) {
        add("qw,qx,qy,qz", "a quaternion of length " + text_of(1e-4 * std::round(1e4 * norm)),
            "a unit quaternion (not angles in degrees)");
      }
      sample.turn = root_from_table_ * turn.normalized() * root_from_table_.inverse();
    }
    if (problems_.empty()) samples_.push_back(sample);
  }

  void check_time(double t_s) {
    const std::string since = " (line " + std::to_string(last_line_) + " is at " + text_of(last_s_) + ")";
    constexpr double rounding_s = 1e-9;
    if (!(t_s > last_s_)) {
      add("t_s", text_of(t_s) + since, "a later time than in the row before");
    } else if (t_s - last_s_ > config_.max_gap_s + rounding_s) {
      add("t_s", text_of(t_s) + since, "rows at most max_gap_s (" + text_of(config_.max_gap_s) + " s) apart");
    }
  }

  const MotionFileConfig& config_;
  Eigen::Vector3d origin_m_;
  Eigen::Quaterniond root_from_table_;
  std::array<std::optional<std::size_t>, column_names.size()> place_{};  ///< of a column among the cells
  std::size_t columns_ = 0;
  bool turns_ = false;
  int line_ = 0;
  int last_line_ = 0;  ///< of the newest row
  double first_s_ = 0.0;
  double last_s_ = 0.0;
  std::vector<MotionSample> samples_;
  std::vector<Problem> problems_;
};

}  // namespace

void describe(FieldVisitor& v, MotionFileConfig& c) {
  constexpr Range metres{-50.0, 50.0};
  v.path("file", c.file, "table of the motion, t_s,x_m,y_m,z_m[,qw,qx,qy,qz]; relative to the scenario");
  v.require(!c.file.empty(), "file", "no such key", "the path of a table");
  v.real("max_gap_s", c.max_gap_s, {0.0001, 60.0}, "longest time from one row to the next");
  v.reals("origin_m", c.origin_m, metres, "place of the table's origin, root frame");
  v.reals("axes_turn_deg", c.axes_turn_deg, {-360.0, 360.0},
          "rotation of the table's axes into the root frame, a rotation vector");
}

MotionTable read_motion_file(const MotionFileConfig& config) { return MotionTableReader(config).read(); }

}  // namespace saccade
