#pragma once

#include <cmath>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

#include "core/random.h"
#include "evaluation/report/overlay.h"
#include "evaluation/scoring/gaze_scorer.h"
#include "evaluation/scoring/metrics.h"
#include "head/icub_cameras.h"
#include "recording/event_file.h"
#include "recording/run_files.h"

namespace saccade {

/// Writes a run folder with made-up motion: the ball moves along a square, the eye follows it late, one detector is
/// good and the other one often detects clutter. With `images` it has saved images of eye, scene and the Hough space of
/// paper_directed.
inline Metrics write_synthetic_run(const std::filesystem::path& folder, bool images, int seed = 1,
                                   int duration_ms = 4000) {
  namespace fs = std::filesystem;
  constexpr double rad = std::numbers::pi / 180.0;
  constexpr double ball_radius_m = 0.0475;
  const RandomStream random(static_cast<std::uint64_t>(4 + seed), "synthetic run");
  fs::remove_all(folder);
  fs::create_directories(folder / "frames");

  const Camera camera = icub_left_2016;
  GazeScoringConfig scoring;
  scoring.camera = camera;
  scoring.acquire_within_rad = 6.0 * rad;
  scoring.limits.min_rad.head<joint_count>() << -22, -39, -59, -40, -70, -55, -35, -50, 0;
  scoring.limits.max_rad.head<joint_count>() << 84, 39, 59, 30, 60, 55, 15, 52, 90;
  scoring.limits.min_rad *= rad;
  scoring.limits.max_rad *= rad;
  GazeScorer gaze_scorer(scoring);

  TableWriter<TruthRow> truth_file(folder / "truth.csv");
  TableWriter<DetectionRow> detection_file(folder / "detections.csv");
  TableWriter<GazeRow> gaze_file(folder / "gaze.csv");
  TableWriter<EyeRow> eye_file(folder / "eye.csv");
  const auto event_file = create_event_file(folder / "events.csv", camera.size);
  std::vector<TruthRow> truth;
  std::vector<DetectionRow> detections;
  std::vector<Event> events;

  const Eigen::Vector3d eye_m(-0.056, -0.034, 0.347);
  Eigen::Vector2d aim(0.0, 0.0);  // right and up, m at 0.45 m ahead
  Eigen::Vector3d target_m = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  std::int64_t event_count = 0;
  for (int t_ms = 1; t_ms <= duration_ms; ++t_ms) {
    const auto step = static_cast<std::uint64_t>(t_ms);
    const double side = std::clamp((t_ms - 300) / 900.0, 0.0, 4.0);
    const double along = 0.2 * (side - std::floor(side)) - 0.1;
    const int edge = std::min(3, static_cast<int>(side));
    const Eigen::Vector2d square = edge == 0   ? Eigen::Vector2d(-0.1, along)
                                   : edge == 1 ? Eigen::Vector2d(along, 0.1)
                                   : edge == 2 ? Eigen::Vector2d(0.1, -along)
                                               : Eigen::Vector2d(-along, -0.1);
    const Eigen::Vector3d ball_m = eye_m + Eigen::Vector3d(-0.45, square.x(), square.y());
    aim += 0.01 * (square - aim);

    const Eigen::Vector3d forward = Eigen::Vector3d(-0.45, aim.x(), aim.y()).normalized();
    const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
    GazeSample sample;
    sample.t_us = t_ms * 1000;
    sample.root_from_left_cam.linear().col(0) = right;
    sample.root_from_left_cam.linear().col(1) = forward.cross(right);
    sample.root_from_left_cam.linear().col(2) = forward;
    sample.root_from_left_cam.translation() = eye_m;
    sample.ball_m = ball_m;
    sample.plant_position_rad[neck_yaw] = -0.6 * std::atan2(aim.x(), 0.45);
    sample.plant_position_rad[neck_pitch] = 0.6 * std::atan2(aim.y(), 0.45);
    sample.plant_position_rad[eyes_version] = 0.4 * std::atan2(aim.x(), 0.45);
    sample.plant_position_rad[eyes_tilt] = 0.4 * std::atan2(aim.y(), 0.45);
    if (t_ms % 40 == 0)
      target_m = ball_m + 0.004 * Eigen::Vector3d(random.normal(1, step), random.normal(2, step), 0);
    if (target_m.allFinite()) sample.target_m = target_m;
    gaze_scorer.add(sample);

    const Circle circle = *camera.project_sphere(sample.root_from_left_cam.inverse() * ball_m, ball_radius_m);
    truth.push_back({.t_us = sample.t_us, .circle = circle, .visible = 1.0, .position_m = ball_m});
    truth_file.write(truth.back());
    eye_file.write(EyeRow::of(sample.t_us, sample.root_from_left_cam));
    gaze_file.write({.t_us = sample.t_us,
                     .fixation_m = eye_m + 0.45 * forward,
                     .target_m = target_m,
                     .position_rad = sample.plant_position_rad});

    const auto detect = [&](const char* name, std::uint64_t salt, double clutter, double noise_px) {
      if (random.uniform(salt, step) < 0.3) return;
      const bool wrong = random.uniform(salt + 1, step) < clutter;
      const Circle found = wrong ? Circle{std::round(90 + 4 * random.normal(salt + 2, step)), 40, 12}
                                 : Circle{std::round(circle.x_px + noise_px * random.normal(salt + 3, step)),
                                          std::round(circle.y_px + noise_px * random.normal(salt + 4, step)),
                                          std::round(circle.r_px + 0.5 * random.normal(salt + 5, step))};
      detections.push_back({.t_us = sample.t_us,
                            .detector = name,
                            .circle = found,
                            .score = (wrong ? 0.4 : 0.55) + 0.1 * random.normal(salt + 6, step)});
      detection_file.write(detections.back());
    };
    detect("paper_full", 10, 0.6, 2.0);
    detect("paper_directed", 20, 0.1, 1.0);

    events.clear();
    for (std::uint64_t k = 0; k < 40; ++k) {
      const double phase = 2.0 * std::numbers::pi * random.uniform(30 + k, step);
      const bool clutter = k >= 25;
      const double x =
          clutter ? 128.0 * random.uniform(100 + k, step) : circle.x_px + circle.r_px * std::cos(phase);
      const double y = clutter ? 10.0 * std::floor(13.0 * random.uniform(200 + k, step))
                               : circle.y_px + circle.r_px * std::sin(phase);
      if (x > 0 && y > 0 && x < 127 && y < 127) {
        events.push_back({.t_us = sample.t_us - 1000 + static_cast<std::int64_t>(25 * k) + 1,
                          .x = static_cast<std::uint16_t>(std::lround(x)),
                          .y = static_cast<std::uint16_t>(std::lround(y)),
                          .on = std::cos(phase) > 0.0});
      }
    }
    event_file->write(events);
    event_count += std::ssize(events);

    if (images && t_ms % 500 == 0) {
      cv::Mat eye(camera.size.height, camera.size.width, CV_8UC1);
      for (int y = 0; y < eye.rows; ++y) {
        for (int x = 0; x < eye.cols; ++x)
          eye.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(110 + x / 4 + 30 * (y / 10 % 2));
      }
      cv::circle(eye, cv::Point(static_cast<int>(circle.x_px), static_cast<int>(circle.y_px)),
                 static_cast<int>(circle.r_px), 60, cv::FILLED, cv::LINE_AA);
      cv::imwrite((folder / "frames" / (std::to_string(sample.t_us) + "_eye.png")).string(), eye);
      std::vector<float> response(static_cast<std::size_t>(camera.size.pixels()));
      for (int y = 0; y < camera.size.height; ++y) {
        for (int x = 0; x < camera.size.width; ++x) {
          const double off_px = std::hypot(x - circle.x_px, y - circle.y_px);
          response[static_cast<std::size_t>(y * camera.size.width + x)] =
              static_cast<float>(0.75 * std::exp(-0.2 * off_px));
        }
      }
      cv::imwrite(
          (folder / "frames" / (std::to_string(sample.t_us) + "_paper_directed_hough_0.75.png")).string(),
          response_image(response, camera.size));
      cv::Mat scene(480, 640, CV_8UC3, cv::Scalar(180, 170, 160));
      cv::circle(
          scene,
          cv::Point(320 + static_cast<int>(1500 * square.x()), 240 - static_cast<int>(1500 * square.y())), 40,
          {40, 120, 230}, cv::FILLED, cv::LINE_AA);
      cv::imwrite((folder / "frames" / (std::to_string(sample.t_us) + "_scene.png")).string(), scene);
    }
  }
  truth_file.commit();
  detection_file.commit();
  gaze_file.commit();
  eye_file.commit();
  event_file->commit();

  Metrics metrics;
  metrics.scenario = "synthetic square <45 cm>";
  metrics.seed = seed;
  metrics.duration_s = duration_ms * 1e-3;
  metrics.wall_s = 3.1;
  metrics.event_count = event_count;
  metrics.events_dropped = 0;
  metrics.events_file = "events.csv";
  metrics.image = camera.size;
  metrics.camera = camera;
  for (const char* name : {"paper_full", "paper_directed"}) {
    DetectorScore score = score_detector(truth, detections, name, 0.45, Chances::simulated);
    score.us_per_event = 0.31;
    metrics.detectors.emplace_back(name, std::move(score));
  }
  metrics.gaze = GazeMetrics{.detector = "paper_directed",
                             .controller = "qp",
                             .gate = "authors",
                             .window = "1500 events",
                             .score = gaze_scorer.score(),
                             .following_rate_hz = 630.0,
                             .limits = scoring.limits};
  write_metrics(folder / "metrics.json", metrics);
  return metrics;
}

}  // namespace saccade
