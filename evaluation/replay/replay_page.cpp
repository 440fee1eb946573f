#include "evaluation/replay/replay_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/units.h"
#include "evaluation/replay/kept_events.h"
#include "evaluation/replay/packed_table.h"
#include "evaluation/replay/replay_asset.h"
#include "evaluation/replay/scene_file.h"
#include "evaluation/report/html.h"
#include "evaluation/report/palette.h"
#include "evaluation/report/run_data.h"
#include "evaluation/scoring/eye_movement.h"
#include "evaluation/scoring/metrics.h"
#include "head/head_model.h"
#include "recording/event_file.h"
#include "recording/output_file.h"
#include "recording/run_file_names.h"
#include "recording/run_files.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr double none = std::numeric_limits<double>::quiet_NaN();
// Smaller than a pixel of a screen, and than what matters.
constexpr double px_step = 0.01;
constexpr double m_step = 1e-4;
constexpr double deg_step = 0.01;
constexpr double score_step = 1e-4;

/// What a page holds, as it grows.
class Page {
 public:
  Page(std::string title, std::int64_t start_us) : start_us_(start_us) {
    head_["title"] = std::move(title);
    head_["start_us"] = start_us;
    head_["tables"] = Json::array();
  }

  Json& head() { return head_; }
  [[nodiscard]] std::int64_t since_start(std::int64_t t_us) const {
    return std::max<std::int64_t>(0, t_us - start_us_);
  }

  void add(const PackedTable& table) {
    head_["tables"].push_back(table.description());
    contents_.push_back(table.content());
  }

  /// A table with a time and numbers of each row. `columns`: name, step, value.
  template <class Row>
  struct NumberColumn {
    std::string name;
    double step;
    std::function<double(const Row&)> value;
  };
  template <class Row>
  void add_rows(const std::string& name, const std::vector<Row>& rows,
                const std::vector<NumberColumn<Row>>& columns) {
    if (rows.empty()) return;
    PackedTable table(name, rows.size());
    std::vector<std::int64_t> times;
    times.reserve(rows.size());
    for (const Row& row : rows) times.push_back(since_start(row.t_us));
    table.add_times("t", times);
    std::vector<double> values(rows.size());
    for (const auto& column : columns) {
      std::ranges::transform(rows, values.begin(), column.value);
      table.add_numbers(column.name, column.step, values);
    }
    add(table);
  }

  [[nodiscard]] std::string html(const std::string& scene) const;

 private:
  std::int64_t start_us_;
  Json head_;
  std::vector<std::string> contents_;
};

std::string Page::html(const std::string& scene) const {
  std::string data;
  for (std::size_t i = 0; i < contents_.size(); ++i) {
    data += "<script type=\"text/plain\" class=\"table\">" + contents_[i] + "</script>\n";
  }
  const std::string title = escaped(head_.at("title").get<std::string>());
  std::string libraries;
  if (!scene.empty()) {
    libraries = "<script>\n" + std::string(replay_asset("three_licence.js")) +
                std::string(replay_asset("three.min.js")) + "</script>\n<script>" +
                std::string(replay_asset("OrbitControls.js")) + "</script>\n";
  }
  std::string script;
  for (const char* const name : {"page.js", "tables.js", "plot.js", "eye.js", "scene.js", "replay.js"})
    script += replay_asset(name);
  return filled_page(replay_asset("replay.html"), {{"title", title},
                                                   {"style", replay_asset("replay.css")},
                                                   {"head", in_script(head_.dump())},
                                                   {"scene", scene},
                                                   {"data", data},
                                                   {"libraries", libraries},
                                                   {"script", script}});
}

/// How often events came, per bin of whole milliseconds.
struct EventRates {
  std::int64_t bin_us = 1'000;
  std::vector<std::int64_t> on;
  std::vector<std::int64_t> off;

  EventRates(double duration_s) {
    constexpr double most_bins = 4'000;
    bin_us = 1'000 * std::max<std::int64_t>(2, static_cast<std::int64_t>(duration_s * 1e3 / most_bins) + 1);
  }
  void add(std::int64_t t_us, bool is_on) {
    if (t_us < 0) return;
    const auto bin = static_cast<std::size_t>(t_us / bin_us);
    constexpr std::size_t absurd = 1 << 20;  // a wrong time stamp
    if (bin >= absurd) return;
    if (bin >= on.size()) {
      on.resize(bin + 1);
      off.resize(bin + 1);
    }
    ++(is_on ? on : off)[bin];
  }
};

void add_events(Page& page, const KeptEvents& kept, std::uint8_t camera, const std::string& name,
                ImageSize size) {
  const std::vector<Event> events = kept.of(camera);
  if (events.empty()) return;
  PackedTable table(name, events.size());
  std::vector<std::int64_t> times;
  std::vector<std::uint16_t> x;
  std::vector<std::uint16_t> y;
  std::vector<bool> on;
  for (const Event& event : events) {
    times.push_back(page.since_start(event.t_us));
    x.push_back(event.x);
    y.push_back(event.y);
    on.push_back(event.on);
  }
  constexpr int byte_values = 256;
  const auto is_wide = [](int length, const std::vector<std::uint16_t>& values) {
    return length > byte_values || std::ranges::max(values) >= byte_values;
  };
  table.add_times("t", times);
  table.add_words("x", is_wide(size.width, x), x);
  table.add_words("y", is_wide(size.height, y), y);
  table.add_bits("on", on);
  page.add(table);
}

void add_rates(Page& page, const EventRates& rates) {
  if (rates.on.empty()) return;
  PackedTable table("rates", rates.on.size());
  std::vector<std::int64_t> times;
  std::vector<double> on;
  std::vector<double> off;
  for (std::size_t i = 0; i < rates.on.size(); ++i) {
    times.push_back(static_cast<std::int64_t>(i) * rates.bin_us + rates.bin_us / 2);
    const double per_ms = 1e3 / static_cast<double>(rates.bin_us);
    on.push_back(static_cast<double>(rates.on[i]) * per_ms);
    off.push_back(static_cast<double>(rates.off[i]) * per_ms);
  }
  constexpr double rate_step = 0.1;
  table.add_times("t", times);
  table.add_numbers("on", rate_step, on);
  table.add_numbers("off", rate_step, off);
  page.add(table);
}

/// The rest of a recording, event by event.
template <class Take>
void read_all(EventReader& reader, Take take) {
  std::vector<Event> block;
  constexpr std::size_t block_events = 65'536;
  while (reader.read(block, block_events) > 0) {
    std::ranges::for_each(block, take);
    block.clear();
  }
}

Json colours() {
  return {{"on", hex(on_colour)},
          {"off", hex(off_colour)},
          {"truth", hex(truth_colour)},
          {"gaze", hex(gaze_colour)},
          {"target", hex(gaze_target_colour)}};
}

void note_events(Page& page, const KeptEvents& kept) {
  page.head()["events"] = {{"total", kept.total()}, {"kept", kept.kept()}, {"every", kept.every()}};
}

void add_truth(Page& page, const std::string& name, const std::vector<TruthRow>& rows) {
  page.add_rows<TruthRow>(name, rows,
                          {{"x", px_step, [](const TruthRow& r) { return r.circle.x_px; }},
                           {"y", px_step, [](const TruthRow& r) { return r.circle.y_px; }},
                           {"r", px_step, [](const TruthRow& r) { return r.circle.r_px; }},
                           {"visible", 0.01, [](const TruthRow& r) { return r.visible; }},
                           {"ball_x", m_step, [](const TruthRow& r) { return r.position_m.x(); }},
                           {"ball_y", m_step, [](const TruthRow& r) { return r.position_m.y(); }},
                           {"ball_z", m_step, [](const TruthRow& r) { return r.position_m.z(); }}});
}

Json add_detectors(Page& page, const std::string& prefix, const std::vector<DetectionRow>& rows,
                   const std::vector<std::pair<std::string, DetectorScore>>& detectors) {
  Json list = Json::array();
  for (const auto& [name, score] : detectors) {
    std::vector<DetectionRow> own;
    std::ranges::copy_if(rows, std::back_inserter(own),
                         [&name = name](const DetectionRow& row) { return row.detector == name; });
    const std::string table = prefix + std::to_string(list.size());
    page.add_rows<DetectionRow>(table, own,
                                {{"x", px_step, [](const DetectionRow& r) { return r.circle.x_px; }},
                                 {"y", px_step, [](const DetectionRow& r) { return r.circle.y_px; }},
                                 {"r", px_step, [](const DetectionRow& r) { return r.circle.r_px; }},
                                 {"score", score_step, [](const DetectionRow& r) { return r.score; }},
                                 {"held", 1.0, [](const DetectionRow& r) { return r.held ? 1.0 : 0.0; }}});
    list.push_back({{"name", name},
                    {"colour", hex(detector_colour(name))},
                    {"threshold", score.threshold},
                    {"table", table}});
  }
  return list;
}

/// The row of the same time, where there is one; `next` goes forward over calls.
template <class Row>
const Row* at_time(const std::vector<Row>& rows, std::size_t& next, std::int64_t t_us) {
  while (next < rows.size() && rows[next].t_us < t_us) ++next;
  return next < rows.size() && rows[next].t_us == t_us ? &rows[next] : nullptr;
}

/// The left eye's axis, and how far off the ball it is.
void add_eye(Page& page, const std::vector<EyeRow>& eye, const std::vector<TruthRow>& truth) {
  std::size_t next = 0;
  const auto axis = [](const EyeRow& row) -> Eigen::Vector3d {
    return row.root_from_left_cam().linear().col(2);
  };
  page.add_rows<EyeRow>("eye", eye,
                        {{"x", m_step, [](const EyeRow& r) { return r.position_m.x(); }},
                         {"y", m_step, [](const EyeRow& r) { return r.position_m.y(); }},
                         {"z", m_step, [](const EyeRow& r) { return r.position_m.z(); }},
                         {"axis_x", m_step, [&](const EyeRow& r) { return axis(r).x(); }},
                         {"axis_y", m_step, [&](const EyeRow& r) { return axis(r).y(); }},
                         {"axis_z", m_step, [&](const EyeRow& r) { return axis(r).z(); }},
                         {"error", deg_step, [&](const EyeRow& r) {
                            const TruthRow* const ball = at_time(truth, next, r.t_us);
                            return ball == nullptr ? none
                                                   : angle_deg(axis(r), ball->position_m - r.position_m);
                          }}});
}

/// Target and fixation point, the target in the left image, and the joints.
void add_gaze(Page& page, const std::vector<GazeRow>& gaze, const std::vector<EyeRow>& eye,
              const Metrics& metrics) {
  using Column = Page::NumberColumn<GazeRow>;
  std::vector<Eigen::Vector2d> target_px;
  std::size_t next = 0;
  for (const GazeRow& row : gaze) {
    std::optional<Eigen::Vector2d> px;
    const EyeRow* const camera = at_time(eye, next, row.t_us);
    if (camera != nullptr && metrics.camera && row.target_m.allFinite())
      px = metrics.camera->project(camera->root_from_left_cam().inverse() * row.target_m);
    target_px.push_back(px.value_or(Eigen::Vector2d(none, none)));
  }
  const auto pixel = [&](const GazeRow& row) {
    return target_px[static_cast<std::size_t>(&row - gaze.data())];
  };
  std::vector<Column> columns = {{"target_x", m_step, [](const GazeRow& r) { return r.target_m.x(); }},
                                 {"target_y", m_step, [](const GazeRow& r) { return r.target_m.y(); }},
                                 {"target_z", m_step, [](const GazeRow& r) { return r.target_m.z(); }},
                                 {"fixation_x", m_step, [](const GazeRow& r) { return r.fixation_m.x(); }},
                                 {"fixation_y", m_step, [](const GazeRow& r) { return r.fixation_m.y(); }},
                                 {"fixation_z", m_step, [](const GazeRow& r) { return r.fixation_m.z(); }},
                                 {"target_px_x", px_step, [&](const GazeRow& r) { return pixel(r).x(); }},
                                 {"target_px_y", px_step, [&](const GazeRow& r) { return pixel(r).y(); }}};
  Json joints = Json::array();
  if (metrics.gaze && metrics.gaze->limits.head) {
    for (const HeadJoint& joint : metrics.gaze->limits.head->joints) {
      const int slot = joint.slot;
      constexpr double still_rad = 0.1 / deg_per_rad;
      const auto [least, most] = std::ranges::minmax_element(
          gaze, {}, [slot](const GazeRow& row) { return row.position_rad[slot]; });
      if (least == gaze.end() || most->position_rad[slot] - least->position_rad[slot] < still_rad) continue;
      std::string column = "joint_" + std::to_string(joints.size());
      joints.push_back({{"name", joint.name}, {"column", column}});
      columns.push_back({std::move(column), deg_step,
                         [slot](const GazeRow& r) { return r.position_rad[slot] * deg_per_rad; }});
    }
  }
  page.head()["joints"] = std::move(joints);
  page.add_rows<GazeRow>("gaze", gaze, columns);
}

/// packed(); empty where there is none.
std::string packed_scene(const fs::path& file) {
  const std::string text = scene_text(file);
  return text.empty() ? text : packed({reinterpret_cast<const unsigned char*>(text.data()), text.size()});
}

void write_html(const fs::path& file, const std::string& html) {
  OutputFile out(file);
  out.write(html);
  out.commit();
}

}  // namespace

void write_replay(const fs::path& run_folder, const FormatRegistry& formats, const fs::path& file) {
  const Metrics metrics = read_metrics(run_folder / run_file::metrics);
  const std::int64_t start_us = metrics.start_us;
  const std::int64_t step_ms = report_step_ms(metrics.duration_s);
  const auto rows = [&]<class Row>(const char* name, Row) {
    return read_thinned_table<Row>(run_folder / name, start_us, step_ms);
  };
  const std::string scene = packed_scene(run_folder / run_file::scene);
  Page page(metrics.scenario, start_us);
  Json& head = page.head();
  head["duration"] = metrics.duration_s;
  head["size"] = {metrics.image.width, metrics.image.height};
  head["colours"] = colours();
  if (metrics.camera) head["principal"] = {metrics.camera->cx_px, metrics.camera->cy_px};
  if (metrics.seed) head["seed"] = *metrics.seed;
  head["interrupted"] = metrics.interrupted;
  head["report"] = fs::exists(run_folder / run_file::report);

  const std::uint8_t camera = metrics.events_camera.value_or(0);
  KeptEvents kept;
  EventRates rates(metrics.duration_s);
  if (!metrics.events_file.empty()) {
    try {
      const auto reader = open_event_file(formats, run_folder / metrics.events_file);
      const auto end_us = start_us + static_cast<std::int64_t>(metrics.duration_s * 1e6) + 1'000;
      read_all(*reader, [&](const Event& event) {
        if (event.t_us < start_us || event.t_us > end_us)
          return;  // of a recording that was not processed to its end
        if (event.camera == camera) rates.add(event.t_us - start_us, event.on);
        if (event.camera == camera || metrics.right_eye) kept.add(event);
      });
    } catch (const InputError& error) {
      head["events_remark"] = error.what();
    }
  }
  note_events(page, kept);
  add_events(page, kept, camera, "events", metrics.image);
  if (metrics.right_eye) add_events(page, kept, 1, "events_right", metrics.image);
  add_rates(page, rates);

  const auto truth = rows(run_file::truth, TruthRow{});
  const auto eye = rows(run_file::eye, EyeRow{});
  add_truth(page, "truth", truth);
  head["detectors"] =
      add_detectors(page, "detections_", rows(run_file::detections, DetectionRow{}), metrics.detectors);
  if (metrics.right_eye) {
    add_truth(page, "truth_right", rows(run_file::truth_right, TruthRow{}));
    head["right_detectors"] =
        add_detectors(page, "right_detections_", rows(run_file::detections_right, DetectionRow{}),
                      metrics.right_eye->detectors);
  }
  add_eye(page, eye, truth);
  add_gaze(page, rows(run_file::gaze, GazeRow{}), eye, metrics);
  write_html(file, page.html(scene));
}

void write_recording_replay(const fs::path& recording, const FormatRegistry& formats,
                            const EventReadOptions& options, const fs::path& file) {
  const auto reader = open_event_file(formats, recording, options);
  KeptEvents kept;
  std::optional<std::int64_t> first_us;
  std::int64_t last_us = std::numeric_limits<std::int64_t>::min();
  ImageSize size = reader->image_size().value_or(ImageSize{});
  const bool has_size = size.pixels() > 0;
  read_all(*reader, [&](const Event& event) {
    first_us = std::min(first_us.value_or(event.t_us), event.t_us);
    last_us = std::max(last_us, event.t_us);
    if (!has_size) size = {std::max(size.width, event.x + 1), std::max(size.height, event.y + 1)};
    kept.add(event);
  });
  if (!first_us) throw InputError(recording.string(), "no events", "a recording with events");
  const double duration_s = static_cast<double>(last_us - *first_us) * 1e-6;
  Page page(recording.filename().string(), *first_us);
  page.head()["duration"] = duration_s;
  page.head()["size"] = {size.width, size.height};
  page.head()["colours"] = colours();
  page.head()["detectors"] = Json::array();
  page.head()["joints"] = Json::array();
  page.head()["interrupted"] = false;
  page.head()["report"] = false;
  note_events(page, kept);
  EventRates rates(duration_s);
  // Of a recording of the right camera alone the page shows that one.
  const bool left = !kept.of(0).empty();
  for (const Event& event : kept.of(left ? 0 : 1)) rates.add(event.t_us - *first_us, event.on);
  for (auto* const counts : {&rates.on, &rates.off}) {
    for (std::int64_t& count : *counts) count *= static_cast<std::int64_t>(kept.every());
  }
  add_events(page, kept, left ? 0 : 1, "events", size);
  if (left) add_events(page, kept, 1, "events_right", size);
  add_rates(page, rates);
  write_html(file, page.html({}));
}

}  // namespace saccade
