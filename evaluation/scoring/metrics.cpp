#include "evaluation/scoring/metrics.h"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iterator>

#include "core/error.h"
#include "evaluation/scoring/metrics_json.h"
#include "head/head_model.h"
#include "recording/output_file.h"
#include "recording/run_file_names.h"

namespace saccade {
namespace {

using metrics_json::detector_score, metrics_json::integer, metrics_json::Json, metrics_json::json_of,
    metrics_json::number, metrics_json::percentiles;

std::optional<double> share_of(std::int64_t dropped, std::int64_t transmitted) {
  const double all = static_cast<double>(dropped) + static_cast<double>(transmitted);
  return all > 0.0 ? std::optional(static_cast<double>(dropped) / all) : std::nullopt;
}

std::int64_t left_events(const Metrics& metrics) {
  return metrics.event_count - (metrics.right_eye ? metrics.right_eye->event_count : 0);
}

Json json_of(const ClutterShare& clutter) {
  Json json = {
      {"share", json_of(clutter.share)}, {"by_object", Json::object()}, {"by_cause", Json::object()}};
  for (const auto& [name, share] : clutter.by_object) json["by_object"][name] = json_of(share);
  for (const auto& [name, share] : clutter.by_cause) json["by_cause"][name] = json_of(share);
  return json;
}

ClutterShare clutter_share(const Json& json) {
  ClutterShare clutter;
  clutter.share = number(json.at("share"));
  for (const auto& [name, share] : json.at("by_object").items())
    clutter.by_object.emplace_back(name, number(share));
  for (const auto& [name, share] : json.at("by_cause").items())
    clutter.by_cause.emplace_back(name, number(share));
  return clutter;
}

Json name_or_null(const std::string& name) { return name.empty() ? Json(nullptr) : Json(name); }

Json json_of(const GazeMetrics& gaze) {
  const GazeScore& score = gaze.score;
  Json limits = Json::object();
  for (const HeadJoint& joint : gaze.limits.head->joints)
    limits[joint.name] = {gaze.limits.min_rad[joint.slot], gaze.limits.max_rad[joint.slot]};
  Json json = {{"detector", gaze.detector},
               {"fixation_error_deg", json_of(score.fixation_error_deg)},
               {"on_target_ratio", json_of(score.on_target_ratio)},
               {"in_view_ratio", json_of(score.in_view_ratio)},
               {"acquire_s", json_of(score.acquire_s)},
               {"moves", score.moves},
               {"wrong_moves", score.wrong_moves},
               {"saccades", score.saccades},
               {"limit_violations", score.limit_violations},
               {"target_error_m", {{"median", json_of(score.target_error_median_m)}}},
               {"acquire_within_deg", score.acquire_within_deg},
               {"joint_limits_rad", std::move(limits)},
               {"controller", name_or_null(gaze.controller)},
               {"gate", name_or_null(gaze.gate)},
               {"window", name_or_null(gaze.window)},
               {"acquired_at_us", json_of(score.acquired_at_us)},
               {"following_rate_hz", json_of(gaze.following_rate_hz)}};
  if (!score.exact) json["approximate"] = true;
  if (gaze.eye_movements) json["eye_movements"] = json_of(*gaze.eye_movements);
  if (!gaze.failure.empty()) json["failure"] = gaze.failure;
  return json;
}

GazeMetrics gaze_metrics(const Json& json) {
  GazeMetrics gaze;
  const auto optional = [&](const char* key) { return json.value(key, Json(nullptr)); };
  const auto name = [&](const char* key) {
    const Json value = optional(key);
    return value.is_null() ? std::string() : value.get<std::string>();
  };
  gaze.controller = name("controller");
  gaze.gate = name("gate");
  gaze.window = name("window");
  gaze.score.acquired_at_us = integer(optional("acquired_at_us"));
  gaze.following_rate_hz = number(optional("following_rate_hz"));
  gaze.score.exact = !json.value("approximate", false);
  if (const Json found = optional("eye_movements"); !found.is_null())
    gaze.eye_movements = metrics_json::eye_movement_score(found);
  gaze.failure = json.value("failure", std::string());
  gaze.detector = json.at("detector").get<std::string>();
  gaze.score.fixation_error_deg = percentiles(json.at("fixation_error_deg"));
  gaze.score.on_target_ratio = number(json.at("on_target_ratio"));
  gaze.score.in_view_ratio = number(json.at("in_view_ratio"));
  gaze.score.acquire_s = number(json.at("acquire_s"));
  gaze.score.moves = json.at("moves").get<std::int64_t>();
  gaze.score.wrong_moves = json.at("wrong_moves").get<std::int64_t>();
  gaze.score.saccades = json.at("saccades").get<std::int64_t>();
  gaze.score.limit_violations = json.at("limit_violations").get<std::int64_t>();
  gaze.score.target_error_median_m = number(json.at("target_error_m").at("median"));
  gaze.score.acquire_within_deg = json.at("acquire_within_deg").get<double>();
  const Json& limits = json.at("joint_limits_rad");
  std::vector<std::string> names;
  for (const auto& limit : limits.items()) names.push_back(limit.key());
  names.resize(std::min<std::size_t>(names.size(), gaze_slots));
  gaze.limits.head = head_of_names(names);
  for (const HeadJoint& joint : gaze.limits.head->joints) {
    gaze.limits.min_rad[joint.slot] = limits.at(joint.name).at(0).get<double>();
    gaze.limits.max_rad[joint.slot] = limits.at(joint.name).at(1).get<double>();
  }
  return gaze;
}

Json json_of(ImageSize size, const std::optional<Camera>& camera) {
  Json json = {{"width_px", size.width}, {"height_px", size.height}};
  const auto add = [&](const char* key, double Camera::*member) {
    json[key] = camera ? Json((*camera).*member) : Json(nullptr);
  };
  add("fx_px", &Camera::fx_px);
  add("fy_px", &Camera::fy_px);
  add("cx_px", &Camera::cx_px);
  add("cy_px", &Camera::cy_px);
  add("k1", &Camera::k1);
  add("k2", &Camera::k2);
  add("p1", &Camera::p1);
  add("p2", &Camera::p2);
  if (camera && (camera->lens == LensModel::fisheye || camera->k3 != 0.0)) add("k3", &Camera::k3);
  if (camera && camera->lens == LensModel::fisheye) {
    json["lens"] = word_of(camera->lens);
    add("k4", &Camera::k4);
  }
  return json;
}

Json json_of(const MountedCamera& mounted) {
  Json json = json_of(mounted.camera.size, mounted.camera);
  json["eye_from_camera"] = {{"translation_mm", mounted.mount.translation_mm},
                             {"rotation_deg", mounted.mount.rotation_deg}};
  return json;
}

ImageSize image_size(const Json& camera) {
  return {camera.at("width_px").get<int>(), camera.at("height_px").get<int>()};
}

Camera camera_of(const Json& camera) {
  return {.size = image_size(camera),
          .fx_px = camera.at("fx_px").get<double>(),
          .fy_px = camera.at("fy_px").get<double>(),
          .cx_px = camera.at("cx_px").get<double>(),
          .cy_px = camera.at("cy_px").get<double>(),
          .k1 = camera.value("k1", 0.0),  // runs of before there were lenses
          .k2 = camera.value("k2", 0.0),
          .p1 = camera.value("p1", 0.0),
          .p2 = camera.value("p2", 0.0),
          .lens = camera.value("lens", "") == word_of(LensModel::fisheye) ? LensModel::fisheye
                                                                          : LensModel::radial_tangential,
          .k3 = camera.value("k3", 0.0),
          .k4 = camera.value("k4", 0.0)};
}

MountedCamera mounted_camera(const Json& json) {
  const Json& mount = json.at("eye_from_camera");
  return {camera_of(json),
          {mount.at("translation_mm").get<std::array<double, 3>>(),
           mount.at("rotation_deg").get<std::array<double, 3>>()}};
}

template <class Scores>
Json json_of_all(const Scores& scores) {
  Json detectors = Json::object();
  for (const auto& [name, score] : scores) detectors[name] = json_of(score);
  return detectors;
}

std::vector<std::pair<std::string, DetectorScore>> detector_scores(const Json& json) {
  std::vector<std::pair<std::string, DetectorScore>> scores;
  for (const auto& [name, score] : json.items()) scores.emplace_back(name, detector_score(score));
  return scores;
}

Json json_of(const RightEyeMetrics& eye) {
  return {{"events",
           {{"count", eye.event_count},
            {"dropped", json_of(eye.events_dropped)},
            {"dropped_share", json_of(dropped_share(eye))}}},
          {"camera", json_of(eye.camera.size, eye.camera)},
          {"calibration", json_of(eye.calibration)},
          {"fixation_error_deg", json_of(eye.fixation_error_deg)},
          {"on_target_ratio", json_of(eye.on_target_ratio)},
          {"in_view_ratio", json_of(eye.in_view_ratio)},
          {"detectors", json_of_all(eye.detectors)}};
}

RightEyeMetrics right_eye_metrics(const Json& json) {
  return {.event_count = json.at("events").at("count").get<std::int64_t>(),
          .events_dropped = integer(json.at("events").at("dropped")),
          .camera = camera_of(json.at("camera")),
          .calibration = mounted_camera(json.at("calibration")),
          .fixation_error_deg = percentiles(json.at("fixation_error_deg")),
          .on_target_ratio = number(json.at("on_target_ratio")),
          .in_view_ratio = number(json.at("in_view_ratio")),
          .detectors = detector_scores(json.at("detectors"))};
}

Json json_of(const LatencyMetrics& latency) {
  Json json = {{"kind", latency.kind}, {"detectors", Json::object()}};
  for (const LatencyMetrics::Detector& detector : latency.detectors) {
    json["detectors"][detector.name] = {{"busy_ratio", json_of(detector.busy_ratio)},
                                        {"events_left_out", detector.events_left_out}};
  }
  return json;
}

LatencyMetrics latency_metrics(const Json& json) {
  LatencyMetrics latency;
  latency.kind = json.at("kind").get<std::string>();
  for (const auto& [name, detector] : json.at("detectors").items()) {
    latency.detectors.push_back(
        {name, number(detector.at("busy_ratio")), detector.at("events_left_out").get<std::int64_t>()});
  }
  return latency;
}

Metrics metrics_of(const Json& json) {
  Metrics metrics;
  metrics.scenario = json.at("scenario").get<std::string>();
  metrics.seed = integer(json.at("seed"));
  const Json settings = json.value("settings", Json::object());
  for (const auto& [key, value] : settings.items()) {
    metrics.settings.emplace_back(key, value.get<std::string>());
  }
  metrics.start_us = json.at("start_us").get<std::int64_t>();
  metrics.duration_s = json.at("duration_s").get<double>();
  metrics.wall_s = number(json.at("wall_s"));
  metrics.interrupted = json.value("interrupted", false);
  for (const Json& file : json.value("files", Json::array())) {
    metrics.files.push_back({file.at("key").get<std::string>(), file.at("file").get<std::string>(),
                             file.at("digest").get<std::string>()});
  }
  const Json& events = json.at("events");
  metrics.event_count = events.at("count").get<std::int64_t>();
  metrics.events_dropped = integer(events.at("dropped"));
  metrics.events_file = events.at("file").get<std::string>();
  if (const auto camera = events.find("camera"); camera != events.end())
    metrics.events_camera = *camera == "right" ? 1 : 0;
  metrics.detectors = detector_scores(json.at("detectors"));
  if (!json.at("gaze").is_null()) {
    metrics.gaze = gaze_metrics(json.at("gaze"));
  }
  metrics.controller_failure = json.value("controller_failure", std::string());
  if (const auto clutter = json.find("clutter"); clutter != json.end())
    metrics.clutter = clutter_share(*clutter);
  const Json& camera = json.at("camera");
  metrics.image = image_size(camera);
  if (!camera.at("fx_px").is_null()) metrics.camera = camera_of(camera);
  if (const auto calibration = json.find("calibration"); calibration != json.end())
    metrics.calibration = mounted_camera(*calibration);
  if (const auto eye = json.find("right_eye"); eye != json.end()) metrics.right_eye = right_eye_metrics(*eye);
  if (const auto latency = json.find("latency"); latency != json.end())
    metrics.latency = latency_metrics(*latency);
  return metrics;
}

Json json_of_metrics(const Metrics& metrics) {
  const auto per_second = [](double value, double time_s) {
    return time_s > 0.0 ? std::optional(value / time_s) : std::nullopt;
  };
  Json settings = Json::object();
  for (const auto& [key, value] : metrics.settings) {
    settings[key] = value;
  }
  Json json = {
      {"schema", 1},
      {"scenario", metrics.scenario},
      {"seed", json_of(metrics.seed)},
      {"duration_s", json_of(metrics.duration_s)},
      {"wall_s", json_of(metrics.wall_s)},
      {"real_time_factor", json_of(per_second(metrics.duration_s, metrics.wall_s.value_or(0.0)))},
      {"interrupted", metrics.interrupted},
      {"events",
       {{"count", metrics.event_count},
        {"rate_hz", json_of(per_second(static_cast<double>(metrics.event_count), metrics.duration_s))},
        {"dropped", json_of(metrics.events_dropped)},
        {"file", metrics.events_file},
        {"dropped_share", json_of(dropped_share(metrics))}}},
      {"detectors", json_of_all(metrics.detectors)},
      {"gaze", metrics.gaze ? json_of(*metrics.gaze) : Json(nullptr)},
      {"camera", json_of(metrics.image, metrics.camera)},
      {"start_us", metrics.start_us},
      {"settings", std::move(settings)}};
  if (metrics.events_camera) json["events"]["camera"] = *metrics.events_camera == 0 ? "left" : "right";
  if (metrics.calibration) json["calibration"] = json_of(*metrics.calibration);
  if (!metrics.controller_failure.empty()) json["controller_failure"] = metrics.controller_failure;
  if (metrics.clutter) json["clutter"] = json_of(*metrics.clutter);
  if (metrics.right_eye) json["right_eye"] = json_of(*metrics.right_eye);
  if (metrics.latency) json["latency"] = json_of(*metrics.latency);
  for (const FileDigest& file : metrics.files)
    json["files"].push_back({{"key", file.key}, {"file", file.path}, {"digest", file.digest}});
  return json;
}

std::string text_of_json(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

/// Removes what the clock measured, and where the files lie.
void remove_wall_clock(Json& json) {
  for (const char* key : {"wall_s", "real_time_factor"}) json.erase(key);
  const auto keep_name = [](Json& file) {
    file = std::filesystem::path(file.get<std::string>()).filename().string();
  };
  keep_name(json["events"]["file"]);
  if (const auto files = json.find("files"); files != json.end()) {
    for (Json& file : *files) keep_name(file["file"]);
  }
  const auto remove_times = [](Json& detectors) {
    for (Json& detector : detectors) detector.erase("us_per_event");
  };
  remove_times(json["detectors"]);
  if (const auto eye = json.find("right_eye"); eye != json.end()) remove_times((*eye)["detectors"]);
}

void write_text(const std::filesystem::path& path, const std::string& text) {
  OutputFile file(path);
  file.write(text);
  file.commit();
}

}  // namespace

std::optional<double> dropped_share(const Metrics& metrics) {
  const std::int64_t events = left_events(metrics);
  return metrics.events_dropped ? share_of(*metrics.events_dropped, events) : std::nullopt;
}

std::optional<double> dropped_share(const RightEyeMetrics& eye) {
  return eye.events_dropped ? share_of(*eye.events_dropped, eye.event_count) : std::nullopt;
}

std::string dropped_warning(const std::string& whose, std::int64_t events, std::int64_t dropped) {
  constexpr double tolerated = 0.01;
  const std::optional<double> share = share_of(dropped, events);
  if (!share || *share <= tolerated) return {};
  char percent[16];
  std::snprintf(percent, sizeof percent, "%.1f", 100.0 * *share);
  return whose + " dropped " + percent +
         " % of its events: more arose than its bus transmits (emulator.readout_rate_hz)";
}

std::string dropped_warning(const Metrics& metrics) {
  const bool two = metrics.right_eye.has_value();
  std::string words = dropped_warning(two ? "the left event camera" : "the event camera",
                                      left_events(metrics), metrics.events_dropped.value_or(0));
  if (!two) return words;
  const RightEyeMetrics& eye = *metrics.right_eye;
  const std::string right =
      dropped_warning("the right event camera", eye.event_count, eye.events_dropped.value_or(0));
  if (!words.empty() && !right.empty()) words += "; ";
  return words + right;
}

std::string metrics_to_json(const Metrics& metrics) { return text_of_json(json_of_metrics(metrics)); }

std::string figures_to_json(const Metrics& metrics) {
  Json json = json_of_metrics(metrics);
  remove_wall_clock(json);
  return text_of_json(json);
}

std::string detectors_to_json(const std::vector<std::pair<std::string, DetectorScore>>& scores) {
  return text_of_json({{"schema", 1}, {"detectors", json_of_all(scores)}});
}

Metrics metrics_from_json(std::string_view text, const std::string& place) {
  try {
    const Json json = Json::parse(text);
    if (json.at("schema") != 1) {
      throw InputError(place + ": schema", json.at("schema").dump(), "1");
    }
    return metrics_of(json);
  } catch (const Json::exception& error) {
    throw InputError(place, error.what(), "metrics.json of schema 1");
  }
}

void write_metrics(const std::filesystem::path& path, const Metrics& metrics) {
  write_text(path, metrics_to_json(metrics));
}

void write_figures(const std::filesystem::path& path, const Metrics& metrics) {
  write_text(path, figures_to_json(metrics));
}

Metrics read_metrics(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  if (!file) {
    std::error_code error;
    bool ended = false;  // before its files were complete
    for (const auto& entry : std::filesystem::directory_iterator(path.parent_path(), error))
      ended = ended || entry.path().extension() == ".part" || entry.path().filename() == run_file::scenario;
    throw InputError(path.string(), "no readable file",
                     ended ? "the metrics.json of a run; `saccade repair " + path.parent_path().string() +
                                 "` makes one for a run that was ended before it was complete"
                           : "the metrics.json of a run");
  }
  return metrics_from_json(text, path.string());
}

}  // namespace saccade
