#include "recording/run_files.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <limits>
#include <system_error>
#include <type_traits>

#include "core/config.h"
#include "core/error.h"
#include "head/head_model.h"
#include "recording/codec.h"
#include "recording/number_text.h"
#include "recording/table_reference.h"

namespace saccade {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

template <class Row>
constexpr bool has_joints = std::is_same_v<Row, GazeRow> || std::is_same_v<Row, JointsRow>;

template <class Row>
constexpr bool is_detections = std::is_base_of_v<DetectionRow, Row>;

/// How many columns, from the left, a table may have instead of all.
template <class Row>
constexpr std::array<std::size_t, 2> shorter_tables = {};
template <>
constexpr std::array<std::size_t, 2> shorter_tables<TruthRow> = {4};
template <>
constexpr std::array<std::size_t, 2> shorter_tables<DetectionRow> = {7, 6};

// The columns of each table, once: `visit(name, value, meaning)` in the order of the file. Header, writer, reader and
// reference are visitors; Row is const for a writer.
template <class Visitor, class Vector>
void visit_point(Visitor& visit, std::string_view prefix, Vector& point, std::string_view doc) {
  const std::string name(prefix);
  visit(name + "x_m", point[0], doc);
  visit(name + "y_m", point[1], doc);
  visit(name + "z_m", point[2], doc);
}

template <class Visitor, class Vector>
void visit_joints(Visitor& visit, const HeadModel& head, Vector& position_rad) {
  for (const HeadJoint& joint : head.joints)
    visit(joint.name + "_rad", position_rad[joint.slot], "measured position of the joint");
}

template <class Visitor, class CircleRef>
void visit_circle(Visitor& visit, CircleRef& circle, std::string_view doc) {
  visit("x_px", circle.x_px, doc);
  visit("y_px", circle.y_px, doc);
  visit("r_px", circle.r_px, "its radius");
}

template <class Visitor, class Matrix>
void visit_covariance(Visitor& visit, Matrix& covariance_px2) {
  constexpr std::string_view variance = "variance; empty where the detector has none";
  constexpr std::string_view covariance = "covariance; empty likewise";
  visit("var_x_px2", covariance_px2(0, 0), variance);
  visit("var_y_px2", covariance_px2(1, 1), variance);
  visit("var_r_px2", covariance_px2(2, 2), variance);
  visit("cov_xy_px2", covariance_px2(0, 1), covariance);
  visit("cov_xr_px2", covariance_px2(0, 2), covariance);
  visit("cov_yr_px2", covariance_px2(1, 2), covariance);
}

constexpr std::string_view column_cause = "cause of the event: signal, leak, shot, hot";
constexpr std::string_view column_object =
    "ball, hand, arm, distractor, background: the first in this order of the objects at the pixel before and "
    "after the event";

/// What the instant of a row is.
template <class Row>
constexpr std::string_view time_doc = "instant, in the clock of the events";
template <>
constexpr std::string_view time_doc<DetectionRow> = "instant that the estimate is about";
template <>
constexpr std::string_view time_doc<StreamingRow> =
    "instant at which the newest estimate that was ready counts";
template <>
constexpr std::string_view time_doc<JointsRow> = "instant; of `deploy` the reading's own time";
template <>
constexpr std::string_view time_doc<TimingRow> = "end of the stretch of 0.1 s";
template <>
constexpr std::string_view time_doc<LabelRow> = "time stamp of the event";

template <class Visitor, class Row>
void visit_columns(Visitor& visit, const HeadModel& head, Row& row) {
  using Table = std::remove_const_t<Row>;
  visit("t_us", row.t_us, time_doc<Table>);
  if constexpr (std::is_same_v<Table, TruthRow>) {
    visit_circle(visit, row.circle, "centre of the true circle");
    visit("visible", row.visible, "visible share of the ball's disc in the newest image, 0 to 1");
    visit_point(visit, "", row.position_m, "the ball's centre, root frame");
  } else if constexpr (std::is_same_v<Table, TargetRow>) {
    visit("x_px", row.centre_px[0], "mean of the visible pixels in the newest image of the left eye");
    visit("y_px", row.centre_px[1], "likewise");
    visit("left_px", row.corner_px[0], "the box around them: centre of its top left pixel");
    visit("top_px", row.corner_px[1], "likewise");
    visit("width_px", row.size_px[0], "size of the box");
    visit("height_px", row.size_px[1], "likewise");
    visit("visible", row.visible, "visible share of the target, 0 to 1");
  } else if constexpr (is_detections<Table>) {
    visit("detector", row.detector, "its name");
    visit_circle(visit, row.circle, "centre of the circle");
    visit("score", row.score, "score of the estimate, before any threshold");
    visit("held", row.held, "whether the estimate is held or predicted without events");
    visit_covariance(visit, row.covariance_px2);
    if constexpr (std::is_same_v<Table, StreamingRow>)
      visit("ready_us", row.ready_us, "time from which on the estimate could be used");
  } else if constexpr (std::is_same_v<Table, GazeRow>) {
    visit_point(visit, "fixation_", row.fixation_m, "fixation point, root frame; empty where there is none");
    visit_point(visit, "target_", row.target_m, "gaze target, root frame; empty where there is none");
    visit_joints(visit, head, row.position_rad);
  } else if constexpr (std::is_same_v<Table, EyeRow>) {
    visit_point(visit, "", row.position_m, "true centre of the left camera, root frame");
    visit("qw", row.turn_wxyz[0], "unit quaternion from the camera frame to the root frame");
    visit("qx", row.turn_wxyz[1], "likewise");
    visit("qy", row.turn_wxyz[2], "likewise");
    visit("qz", row.turn_wxyz[3], "likewise");
  } else if constexpr (std::is_same_v<Table, ImuRow>) {
    visit("measured_us", row.reading.t_us, "the reading's own time");
    visit("wx_rad_s", row.reading.angular_velocity_rad_s[0], "angular velocity, frame of the unit");
    visit("wy_rad_s", row.reading.angular_velocity_rad_s[1], "angular velocity, frame of the unit");
    visit("wz_rad_s", row.reading.angular_velocity_rad_s[2], "angular velocity, frame of the unit");
    visit("ax_m_s2", row.reading.acceleration_m_s2[0], "acceleration, frame of the unit");
    visit("ay_m_s2", row.reading.acceleration_m_s2[1], "acceleration, frame of the unit");
    visit("az_m_s2", row.reading.acceleration_m_s2[2], "acceleration, frame of the unit");
  } else if constexpr (std::is_same_v<Table, LabelRow>) {
    visit("x", row.x, "column of the event");
    visit("y", row.y, "row of the event");
    visit("p", row.on, "1: brighter");
    visit("cause", row.cause, column_cause);
    visit("object", row.object, column_object);
  } else if constexpr (std::is_same_v<Table, TimingRow>) {
    visit("state", row.state, "of `deploy`, at the end of the stretch");
    visit("ticks", row.ticks, "ticks done");
    visit("missed", row.missed, "ticks missed");
    visit("late_max_us", row.late_max_us, "largest lateness of a tick");
    visit("tick_mean_us", row.tick_mean_us, "time in a tick, mean");
    visit("tick_max_us", row.tick_max_us, "largest time in a tick");
    visit("latency_mean_us", row.latency_mean_us,
          "from the newest event to the command, mean; empty without one");
    visit("latency_max_us", row.latency_max_us, "the largest");
    visit("events", row.events, "events received");
    visit("events_left_out", row.events_left_out, "of them dropped by ticks that had too many");
    visit("skipped", row.skipped, "detector evaluations skipped");
    visit("queued", row.queued, "events waiting at the end");
    visit("dropped", row.dropped, "events dropped by the connection so far");
  } else {
    static_assert(std::is_same_v<Table, JointsRow>);
    visit_joints(visit, head, row.position_rad);
  }
}

class NameCollector {
 public:
  template <class T>
  void operator()(std::string_view name, T&, std::string_view) {
    names.emplace_back(name);
  }
  std::vector<std::string> names;
};

class ReferenceCollector {
 public:
  template <class T>
  void operator()(std::string_view name, T&, std::string_view doc) {
    const char* type = "number";
    if constexpr (std::is_same_v<T, std::int64_t>) type = "whole number";
    if constexpr (std::is_same_v<T, std::string>) type = "text";
    if constexpr (std::is_same_v<T, bool>) type = "0 or 1";
    columns.push_back({std::string(name), type, std::string(doc)});
  }
  std::vector<ColumnReference> columns;
};

template <class Row>
TableReference reference_of(const char* file) {
  HeadModel head = *default_head();
  head.joints.resize(1);
  head.joints.front().name = "JOINT";
  ReferenceCollector collector;
  Row row;
  visit_columns(collector, head, row);
  return {file, std::move(collector.columns)};
}

template <class Row>
std::vector<std::string> column_names(const HeadModel& head) {
  NameCollector collector;
  Row row;
  visit_columns(collector, head, row);
  return std::move(collector.names);
}

std::string join(const std::vector<std::string>& names, std::size_t count) {
  std::string text;
  for (std::size_t i = 0; i < count; ++i) text += (i == 0 ? "" : ",") + names[i];
  return text;
}

class LineWriter {
 public:
  explicit LineWriter(std::string& line) : line_(line) { line_.clear(); }

  void operator()(std::string_view, const std::int64_t& value, std::string_view) {
    append_number(next(), value);
  }
  void operator()(std::string_view, const bool& value, std::string_view) { next() += value ? '1' : '0'; }
  void operator()(std::string_view, const std::string& value, std::string_view) {
    SACCADE_CHECK(value.find_first_of(",\r\n") == std::string::npos);
    next() += value;
  }
  void operator()(std::string_view, const double& value, std::string_view) {
    std::string& line = next();
    if (std::isfinite(value)) append_number(line, value);
  }

 private:
  std::string& next() {
    if (!first_) line_ += ',';
    first_ = false;
    return line_;
  }

  std::string& line_;
  bool first_ = true;
};

/// Reads the fields of one line into the row that it visits; columns beyond `count` keep what they have.
class LineReader {
 public:
  LineReader(std::string_view line, std::string place, std::size_t count)
      : rest_(line), place_(std::move(place)), left_(count) {}

  void operator()(std::string_view name, std::int64_t& value, std::string_view) {
    const auto field = next();
    if (field && !parse_number(*field, value)) fail(name, *field, "a whole number");
  }
  void operator()(std::string_view name, bool& value, std::string_view) {
    const auto field = next();
    if (!field) return;
    if (*field != "0" && *field != "1") fail(name, *field, "0 or 1");
    value = *field == "1";
  }
  void operator()(std::string_view name, std::string& value, std::string_view) {
    const auto field = next();
    if (!field) return;
    if (field->empty()) fail(name, *field, "a name");
    value = *field;
  }
  void operator()(std::string_view name, double& value, std::string_view) {
    const auto field = next();
    if (!field) return;
    value = nan;
    if (field->empty()) return;
    if (!parse_number(*field, value) || !std::isfinite(value))
      fail(name, *field, "a finite number or nothing");
  }

 private:
  std::optional<std::string_view> next() {
    if (left_ == 0) return std::nullopt;
    --left_;
    const std::size_t end = std::min(rest_.find(','), rest_.size());
    const std::string_view field = rest_.substr(0, end);
    rest_.remove_prefix(std::min(end + 1, rest_.size()));
    return field;
  }

  [[noreturn]] void fail(std::string_view name, std::string_view field, std::string_view expectation) const {
    throw InputError(place_ + ", column " + std::string(name), field.empty() ? "nothing" : printable(field),
                     std::string(expectation));
  }

  std::string_view rest_;
  std::string place_;
  std::size_t left_;
};

/// The head whose joints are the columns of a table's header; the default one where they are no joints.
template <class Row>
std::shared_ptr<const HeadModel> head_of_header(std::string_view header) {
  if constexpr (!has_joints<Row>) {
    return default_head();
  } else {
    constexpr std::string_view suffix = "_rad";
    const std::size_t others = column_names<Row>(*default_head()).size() - default_head()->joints.size();
    std::vector<std::string> names;
    for (std::size_t i = 0; !header.empty(); ++i) {
      const std::size_t end = std::min(header.find(','), header.size());
      const std::string_view name = header.substr(0, end);
      header.remove_prefix(std::min(end + 1, header.size()));
      if (i < others) continue;
      const bool is_joint = name.ends_with(suffix) && is_name(name.substr(0, name.size() - suffix.size()));
      if (!is_joint || names.size() == static_cast<std::size_t>(gaze_slots)) return default_head();
      names.emplace_back(name.substr(0, name.size() - suffix.size()));
    }
    return names.empty() ? default_head() : head_of_names(names);
  }
}

/// How many columns of a Row the header has, from the left.
template <class Row>
std::size_t check_header(const std::string& place, const std::string& header, const HeadModel& head) {
  const std::vector<std::string> names = column_names<Row>(head);
  const auto has = [&](std::size_t count) {
    const std::string text = join(names, count);
    return header == text || (is_detections<Row> && header.starts_with(text + ","));
  };
  if (has(names.size())) return names.size();
  std::string expectation = "the header " + join(names, names.size());
  for (const std::size_t count : shorter_tables<Row>) {
    if (count == 0) continue;
    if (has(count)) return count;
    expectation += " or " + join(names, count);
  }
  throw InputError(place, header.empty() ? "nothing" : printable(header), expectation);
}

std::size_t count_fields(std::string_view line) {
  return line.empty() ? 0 : static_cast<std::size_t>(std::count(line.begin(), line.end(), ',')) + 1;
}

/// The lower half of a covariance that was read, or zero where its fields are empty.
void complete_covariance(Eigen::Matrix3d& covariance_px2, const std::string& place) {
  const Eigen::Matrix3d upper = covariance_px2.triangularView<Eigen::Upper>();
  covariance_px2 = upper.selfadjointView<Eigen::Upper>();
  if (covariance_px2.allFinite()) return;
  const bool empty = upper.array().isNaN().count() == 6;
  if (!empty) throw InputError(place, "a part of a covariance", "all of its six columns, or none");
  covariance_px2.setZero();
}

}  // namespace

std::vector<TableReference> run_tables() {
  return {reference_of<TruthRow>("truth.csv"),
          reference_of<TargetRow>("target.csv"),
          reference_of<DetectionRow>("detections.csv"),
          reference_of<StreamingRow>("streaming.csv"),
          reference_of<GazeRow>("gaze.csv"),
          reference_of<EyeRow>("eye.csv"),
          reference_of<JointsRow>("joints.csv"),
          reference_of<ImuRow>("imu.csv"),
          reference_of<LabelRow>("labels.csv"),
          reference_of<TimingRow>("timing.csv")};
}

EyeRow EyeRow::of(std::int64_t t_us, const Eigen::Isometry3d& root_from_left_cam) {
  const Eigen::Quaterniond turn(root_from_left_cam.linear());
  return {t_us, root_from_left_cam.translation(), {turn.w(), turn.x(), turn.y(), turn.z()}};
}

Eigen::Isometry3d EyeRow::root_from_left_cam() const {
  const Eigen::Quaterniond turn(turn_wxyz[0], turn_wxyz[1], turn_wxyz[2], turn_wxyz[3]);
  return Eigen::Translation3d(position_m) * turn.normalized();
}

template <class Row>
TableWriter<Row>::TableWriter(std::filesystem::path path, std::shared_ptr<const HeadModel> head)
    : head_(std::move(head)), file_(std::move(path)) {
  const std::vector<std::string> names = column_names<Row>(*head_);
  file_.write(join(names, names.size()) + "\n");
}

template <class Row>
void TableWriter<Row>::write(const Row& row) {
  LineWriter writer(line_);
  if constexpr (is_detections<Row>) {
    if (!row.covariance_px2.allFinite() || row.covariance_px2.isZero(0.0)) {
      Row unknown = row;
      unknown.covariance_px2.setConstant(nan);
      visit_columns(writer, *head_, unknown);
    } else {
      visit_columns(writer, *head_, row);
    }
  } else {
    visit_columns(writer, *head_, row);
  }
  line_ += '\n';
  file_.write(line_);
}

template <class Row>
void TableWriter<Row>::sync() {
  file_.sync();
}

template <class Row>
void TableWriter<Row>::commit() {
  file_.commit();
}

template <class Row>
TableReader<Row>::TableReader(const std::filesystem::path& path) : name_(path.string()) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) throw InputError(name_, "a directory", "a table");
  in_.open(path, std::ios::binary);
  if (!in_) throw InputError(name_, std::generic_category().message(errno), "a table");
  next_line();
  columns_ = count_fields(line_);
  head_ = head_of_header<Row>(line_);
  known_ = check_header<Row>(place(), line_, *head_);
}

template <class Row>
std::optional<Row> TableReader<Row>::next() {
  if (!next_line()) return std::nullopt;
  const std::size_t found = count_fields(line_);
  if (found != columns_)
    throw InputError(place(), std::to_string(found) + " fields", std::to_string(columns_));
  Row row;
  if constexpr (std::is_same_v<Row, TruthRow>) {
    row.visible = 1.0;
    row.position_m.setConstant(nan);
  }
  LineReader reader(line_, place(), known_);
  visit_columns(reader, *head_, row);
  if constexpr (is_detections<Row>) complete_covariance(row.covariance_px2, place());
  if (row.t_us < last_t_us_) {
    throw InputError(place() + ", column t_us", std::to_string(row.t_us),
                     "a time that is not before the last row's " + std::to_string(last_t_us_));
  }
  last_t_us_ = row.t_us;
  return row;
}

template <class Row>
bool TableReader<Row>::next_line() {
  ++line_number_;
  const bool found = static_cast<bool>(std::getline(in_, line_));
  if (in_.bad()) throw InputError(place(), "a read error", "a readable file");
  if (!found) line_.clear();
  if (line_.ends_with('\r')) line_.pop_back();
  if (line_number_ == 1) line_ = std::string(without_mark(line_));
  return found;
}

template <class Row>
std::string TableReader<Row>::place() const {
  return name_ + ":" + std::to_string(line_number_);
}

template <class Row>
std::vector<Row> read_table(const std::filesystem::path& path) {
  TableReader<Row> reader(path);
  std::vector<Row> rows;
  while (std::optional<Row> row = reader.next()) rows.push_back(std::move(*row));
  return rows;
}

template class TableWriter<TruthRow>;
template class TableWriter<TargetRow>;
template class TableWriter<DetectionRow>;
template class TableWriter<StreamingRow>;
template class TableWriter<GazeRow>;
template class TableWriter<JointsRow>;
template class TableWriter<EyeRow>;
template class TableWriter<ImuRow>;
template class TableWriter<LabelRow>;
template class TableWriter<TimingRow>;
template class TableReader<TruthRow>;
template class TableReader<TargetRow>;
template class TableReader<DetectionRow>;
template class TableReader<StreamingRow>;
template class TableReader<GazeRow>;
template class TableReader<JointsRow>;
template class TableReader<EyeRow>;
template class TableReader<ImuRow>;
template class TableReader<LabelRow>;
template class TableReader<TimingRow>;
template std::vector<TruthRow> read_table(const std::filesystem::path& path);
template std::vector<TargetRow> read_table(const std::filesystem::path& path);
template std::vector<DetectionRow> read_table(const std::filesystem::path& path);
template std::vector<StreamingRow> read_table(const std::filesystem::path& path);
template std::vector<GazeRow> read_table(const std::filesystem::path& path);
template std::vector<JointsRow> read_table(const std::filesystem::path& path);
template std::vector<ImuRow> read_table(const std::filesystem::path& path);
template std::vector<EyeRow> read_table(const std::filesystem::path& path);
template std::vector<LabelRow> read_table(const std::filesystem::path& path);
template std::vector<TimingRow> read_table(const std::filesystem::path& path);

}  // namespace saccade
