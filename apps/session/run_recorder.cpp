#include "apps/session/run_recorder.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "control/head_kinematics.h"
#include "core/detector_views.h"
#include "evaluation/report/figures.h"

namespace saccade {
namespace {

constexpr std::int64_t picture_window_us = 10'000;  ///< events shown in a picture
constexpr ImageSize scene_size{640, 480};

constexpr std::array<std::string_view, 4> cause_names = {"signal", "leak", "shot", "hot"};  // as EventCause

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

GazeScoringConfig gaze_scoring(const Scenario& scenario, const Camera& camera, const JointLimits& limits) {
  GazeScoringConfig config;
  config.camera = camera;
  config.limits = limits;
  for (const auto& [name, detector] : scenario.detectors) {
    const bool paper = name == scenario.gaze.detector && detector.preset().starts_with("paper");
    if (paper) config.acquire_within_rad = 6.0 * std::numbers::pi / 180.0;
  }
  return config;
}

std::string events_name(const Scenario& scenario) { return "events." + scenario.output.events; }

/// The ball in an eye's image, as a row of its truth table.
TruthRow truth_row(const SimTruth& truth, const EyeTruth& eye) {
  return {truth.t_us, eye.circle.value_or(Circle{nan, nan, nan}), eye.visible, truth.ball_m};
}

cv::Mat grey_picture(const SimEye& eye) {
  const ImageSize size = eye.camera().size;
  cv::Mat grey;
  cv::Mat(size.height, size.width, CV_32F, const_cast<float*>(eye.image().data())).convertTo(grey, CV_8U);
  return grey;
}

void write_png(const std::filesystem::path& path, const cv::Mat& picture) {
  std::vector<unsigned char> png;
  cv::imencode(".png", picture, png);
  OutputFile file(path);
  file.write(std::as_bytes(std::span(png)));
  file.commit();
}

}  // namespace

RunRecorder::Tables::Tables(const std::filesystem::path& folder, const Scenario& scenario, bool stereo)
    : events(create_event_file(folder / events_name(scenario), scenario.sim.camera.size,
                               scenario.sim.both_eyes() ? 2 : 1)),
      joints(folder / "joints.csv"),
      truth(folder / "truth.csv"),
      detections(folder / "detections.csv"),
      gaze(folder / "gaze.csv"),
      eye(folder / "eye.csv") {
  if (scenario.sim.labels) labels.emplace(folder / "labels.csv");
  if (!scenario.sim.both_eyes()) return;
  truth_right.emplace(folder / "truth_right.csv");
  if (stereo) detections_right.emplace(folder / "detections_right.csv");
  if (scenario.sim.labels) labels_right.emplace(folder / "labels_right.csv");
}

void RunRecorder::Tables::commit() {
  events->commit();
  joints.commit();
  truth.commit();
  detections.commit();
  gaze.commit();
  eye.commit();
  if (labels) labels->commit();
  if (truth_right) truth_right->commit();
  if (labels_right) labels_right->commit();
  if (detections_right) detections_right->commit();
}

RunRecorder::RunRecorder(std::optional<std::filesystem::path> folder, const Scenario& scenario,
                         SimRobot& robot, const Loop& loop)
    : folder_(std::move(folder)),
      scenario_(scenario),
      robot_(robot),
      loop_(loop),
      gaze_scorer_(gaze_scoring(scenario, scenario.sim.camera, robot.limits())),
      detector_ns_(scenario.detectors.size(), 0) {
  if (scenario.sim.both_eyes()) {
    right_eye_.emplace(gaze_scoring(scenario, scenario.sim.right.camera, robot.limits()));
  }
  if (const auto& frames = scenario.frame_30hz) {
    frame_detector_.emplace(*frames, scenario.sim.world.ball.rgb, scenario.sim.camera);
    shutter_.emplace(frame_detector_->camera().size, frames->exposure_ms);
  }
  if (!folder_) return;
  tables_.emplace(*folder_, scenario, loop.right_detector() != nullptr);
  const auto duration_us = std::llround(scenario.run.duration_s * 1e6);
  for (std::int64_t i = 0; i < scenario.output.pictures; ++i) {
    const std::int64_t wanted_us = duration_us * (2 * i + 1) / (2 * scenario.output.pictures);
    picture_times_us_.push_back(wanted_us / World::tick_us * World::tick_us);
  }
  if (!picture_times_us_.empty()) std::filesystem::create_directories(*folder_ / "frames");
  if (scenario.output.video) video_.emplace(*folder_ / "video.mp4");
}

void RunRecorder::on_tick(const Tick& tick) {
  now_us_ = tick.t_us;
  record_tables(tick);
  const auto begin = std::chrono::steady_clock::now();
  take_pictures(tick);
  if (frame_detector_) watch_frames(tick.t_us);
  picture_wall_s_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

void RunRecorder::record_tables(const Tick& tick) {
  event_count_ += static_cast<std::int64_t>(tick.events.size());
  if (tables_) tables_->events->write(tick.events);
  if (scenario_.sim.labels) record_labels(tick.events);

  const SimTruth& truth = robot_.truth();
  truth_.push_back(truth_row(truth, truth.left));

  for (std::size_t i = 0; i < tick.detectors.size(); ++i) {
    const DetectorTick& seen = tick.detectors[i];
    detector_ns_[i] += seen.elapsed_ns;
    if (!seen.observed) continue;
    detections_.push_back({tick.t_us, loop_.detectors()[i].name, seen.estimate.circle, seen.estimate.score,
                           seen.estimate.held});
    if (tables_) tables_->detections.write(detections_.back());
  }
  gaze_scorer_.add(
      {tick.t_us, truth.left.root_from_cam, truth.ball_m, tick.target_m, truth.plant_position_rad});
  if (right_eye_) record_right_eye(tick);
  if (!tables_) return;

  const HeadKinematics kinematics(tick.head->position_rad);
  const FixationPoint fixation = kinematics.fixation();
  const Eigen::Vector3d none = Eigen::Vector3d::Constant(nan);
  tables_->joints.write({tick.t_us, tick.head->position_rad});
  tables_->truth.write(truth_.back());
  tables_->gaze.write({tick.t_us, fixation.valid ? fixation.point_m : none, tick.target_m.value_or(none),
                       tick.head->position_rad});
  tables_->eye.write(EyeRow::of(tick.t_us, truth.left.root_from_cam));
}

void RunRecorder::record_right_eye(const Tick& tick) {
  RightEye& eye = *right_eye_;
  const SimTruth& truth = robot_.truth();
  eye.event_count += std::ranges::count_if(tick.events, [](const Event& e) { return e.camera == 1; });
  eye.truth.push_back(truth_row(truth, *truth.right));
  if (tables_) tables_->truth_right->write(eye.truth.back());
  eye.gaze_scorer.add(
      {tick.t_us, truth.right->root_from_cam, truth.ball_m, tick.target_m, truth.plant_position_rad});
  if (!tick.right) return;
  eye.detector_ns += tick.right->elapsed_ns;
  if (!tick.right->observed) return;
  const Estimate& estimate = tick.right->estimate;
  eye.detections.push_back(
      {tick.t_us, scenario_.gaze.detector, estimate.circle, estimate.score, estimate.held});
  if (tables_) tables_->detections_right->write(eye.detections.back());
}

void RunRecorder::record_labels(std::span<const Event> events) {
  const std::span<const EventLabel> labels = robot_.delivered_labels();
  SACCADE_CHECK(labels.size() == events.size());
  LabelRow row;
  for (std::size_t i = 0; i < events.size(); ++i) {
    row.t_us = events[i].t_us;
    row.x = events[i].x;
    row.y = events[i].y;
    row.on = events[i].on;
    row.cause = cause_names.at(static_cast<std::size_t>(labels[i].cause));
    row.object = scene_object_names.at(labels[i].object - 1U);
    if (events[i].camera == 1) {
      if (tables_) tables_->labels_right->write(row);
      continue;
    }
    if (tables_) tables_->labels->write(row);
    clutter_.add(row);
  }
  clutter_in_window_.push_back(clutter_.share_in_window());
}

EyePicture RunRecorder::eye_picture(const Tick& tick, const cv::Mat& grey) const {
  EyePicture eye;
  eye.size = scenario_.sim.camera.size;
  eye.grey = grey;
  eye.events = recent_events_;
  const EyeTruth& truth = robot_.truth().left;
  if (truth.visible > 0.0) eye.truth = truth.circle;
  for (std::size_t i = 0; i < tick.detectors.size(); ++i) {
    const DetectorTick& seen = tick.detectors[i];
    if (!seen.observed || seen.estimate.score < loop_.detectors()[i].detector->threshold()) continue;
    eye.detections.push_back({seen.estimate.circle, loop_.detectors()[i].name, detector_colour(i)});
  }
  eye.principal_px = Eigen::Vector2d(scenario_.sim.camera.cx_px, scenario_.sim.camera.cy_px);
  if (tick.target_m) {
    eye.target_px = scenario_.sim.camera.project(truth.root_from_cam.inverse() * *tick.target_m);
  }
  return eye;
}

void RunRecorder::save_hough_spaces(std::int64_t t_us) const {
  const ImageSize size = scenario_.sim.camera.size;
  std::vector<float> response(static_cast<std::size_t>(size.pixels()));
  for (const LoopDetector& detector : loop_.detectors()) {
    if (!hough_space_of(*detector.detector, response)) continue;
    const float strongest = *std::max_element(response.begin(), response.end());
    write_png(*folder_ / "frames" /
                  fmt::format("{:09}_{}_hough_{:.4g}.png", t_us, file_part(detector.name), strongest),
              response_picture(response, size));
  }
}

void RunRecorder::take_pictures(const Tick& tick) {
  const bool still = std::binary_search(picture_times_us_.begin(), picture_times_us_.end(), tick.t_us);
  const bool film = video_ && video_->wants(tick.t_us);
  if (video_ || !picture_times_us_.empty()) {
    std::ranges::copy_if(tick.events, std::back_inserter(recent_events_),
                         [](const Event& e) { return e.camera == 0; });
    std::erase_if(recent_events_, [&](const Event& e) { return e.t_us <= tick.t_us - picture_window_us; });
  }
  if (!still && !film) return;

  const cv::Mat grey = grey_picture(robot_.left_eye());
  cv::Mat scene(scene_size.height, scene_size.width, CV_8UC3);
  robot_.draw_scene(profile_view(), scene_size,
                    std::span(scene.data, static_cast<std::size_t>(scene_size.pixels()) * 3));
  cv::cvtColor(scene, scene, cv::COLOR_RGB2BGR);
  if (still) {
    write_png(*folder_ / "frames" / fmt::format("{:09}_eye.png", tick.t_us), grey);
    if (right_eye_) {
      write_png(*folder_ / "frames" / fmt::format("{:09}_right_eye.png", tick.t_us),
                grey_picture(*robot_.right_eye()));
    }
    write_png(*folder_ / "frames" / fmt::format("{:09}_scene.png", tick.t_us), scene);
    save_hough_spaces(tick.t_us);
  }
  if (film) {
    video_->add(scene, eye_picture(tick, grey),
                fmt::format("{}   t {:.2f} s   gaze error {:.1f} deg", scenario_.name,
                            static_cast<double>(tick.t_us) * 1e-6,
                            gaze_scorer_.fixation_error_rad() * 180.0 / std::numbers::pi));
  }
}

void RunRecorder::watch_frames(std::int64_t t_us) {
  const auto draw = [this](std::int64_t at_us, const Eigen::Vector2d& shift_px, std::span<float> rgb) {
    robot_.draw_left_eye(at_us, frame_detector_->camera(), shift_px, rgb);
  };
  const std::optional<cv::Mat> image = shutter_->expose(t_us, draw);
  if (!image) return;
  const Estimate ball = frame_detector_->find(*image);
  if (!ball.valid) return;
  detections_.push_back({t_us, std::string(frame_detector_name), ball.circle, ball.score, false});
  if (tables_) tables_->detections.write(detections_.back());
}

GazeMetrics RunRecorder::gaze_metrics(const Metrics& metrics) const {
  GazeMetrics gaze;
  gaze.detector = scenario_.gaze.detector;
  gaze.controller = scenario_.gaze.controller.controller;
  gaze.gate = scenario_.gaze.gate.gate;
  for (const auto& [name, detector] : scenario_.detectors) {
    if (name == gaze.detector) gaze.window = detector.window();
  }
  gaze.score = gaze_scorer_.score();
  gaze.limits = robot_.limits();
  const auto score = std::find_if(metrics.detectors.begin(), metrics.detectors.end(),
                                  [&](const auto& d) { return d.first == gaze.detector; });
  if (gaze.score.acquired_at_us && score != metrics.detectors.end()) {
    gaze.following_rate_hz =
        found_rate_hz(truth_, found_at_chances(truth_, detections_, gaze.detector, score->second.threshold),
                      *gaze.score.acquired_at_us);
  }
  return gaze;
}

RightEyeMetrics RunRecorder::right_eye_metrics() const {
  RightEyeMetrics eye;
  eye.event_count = right_eye_->event_count;
  eye.events_dropped = robot_.right_eye()->counts().dropped;
  eye.camera = scenario_.sim.right.camera;
  eye.calibration = scenario_.right_calibration;
  if (scenario_.gaze.detector != "none") {
    const GazeScore score = right_eye_->gaze_scorer.score();
    eye.fixation_error_deg = score.fixation_error_deg;
    eye.on_target_ratio = score.on_target_ratio;
    eye.in_view_ratio = score.in_view_ratio;
  }
  if (const Detector* detector = loop_.right_detector()) {
    DetectorScore score = score_detector(right_eye_->truth, right_eye_->detections, scenario_.gaze.detector,
                                         detector->threshold(), Chances::simulated);
    if (eye.event_count > 0) {
      score.us_per_event =
          static_cast<double>(right_eye_->detector_ns) * 1e-3 / static_cast<double>(eye.event_count);
    }
    score.rejected_events = detector->rejected();
    eye.detectors.emplace_back(scenario_.gaze.detector, std::move(score));
  }
  return eye;
}

Metrics RunRecorder::finish(double wall_s, std::vector<std::pair<std::string, std::string>> settings) {
  if (tables_) tables_->commit();
  if (video_) video_->commit();

  Metrics metrics;
  metrics.scenario = scenario_.name;
  metrics.seed = scenario_.seed;
  metrics.settings = std::move(settings);
  metrics.duration_s = static_cast<double>(now_us_) * 1e-6;
  metrics.wall_s = wall_s;
  metrics.event_count = event_count_;
  metrics.events_dropped = robot_.left_eye().counts().dropped;
  if (folder_) metrics.events_file = events_name(scenario_);
  metrics.image = scenario_.sim.camera.size;
  metrics.camera = scenario_.sim.camera;
  metrics.calibration = scenario_.calibration;
  const std::int64_t left_events = event_count_ - (right_eye_ ? right_eye_->event_count : 0);
  for (std::size_t i = 0; i < loop_.detectors().size(); ++i) {
    const LoopDetector& detector = loop_.detectors()[i];
    DetectorScore score = score_detector(truth_, detections_, detector.name, detector.detector->threshold(),
                                         Chances::simulated);
    if (left_events > 0) {
      score.us_per_event = static_cast<double>(detector_ns_[i]) * 1e-3 / static_cast<double>(left_events);
    }
    score.rejected_events = detector.detector->rejected();
    metrics.detectors.emplace_back(detector.name, std::move(score));
  }
  if (frame_detector_) {
    metrics.detectors.emplace_back(frame_detector_name,
                                   score_detector(truth_, detections_, frame_detector_name,
                                                  frame_detector_->threshold(), Chances::simulated));
  }
  if (scenario_.sim.labels) {
    metrics.clutter = clutter_.share();
    for (auto& [name, score] : metrics.detectors) {
      score.clutter = detector_clutter(truth_, clutter_in_window_, detections_, name, score.threshold,
                                       clutter_.clutter_events(), score.inliers);
    }
  }
  if (scenario_.gaze.detector != "none") {
    metrics.gaze = gaze_metrics(metrics);
  }
  if (right_eye_) metrics.right_eye = right_eye_metrics();
  if (folder_) write_metrics(*folder_ / "metrics.json", metrics);
  return metrics;
}

std::vector<std::pair<std::string, std::string>> settings_of(const std::vector<std::string>& assignments) {
  std::map<std::string, std::string> settings;
  for (const std::string& assignment : assignments) {
    const std::size_t equals = assignment.find('=');
    const std::string key = assignment.substr(0, equals);
    const std::string section = key.substr(0, key.find('.'));
    if (section == "output" || section == "run" || section == "seed" || section == "expect") continue;
    settings[key] = assignment.substr(equals + 1);
  }
  return {settings.begin(), settings.end()};
}

}  // namespace saccade
