#include "session/run_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "core/detector_views.h"
#include "evaluation/image_codecs/image_codecs.h"
#include "evaluation/report/figures.h"
#include "evaluation/report/overlay.h"
#include "session/run_scores.h"

namespace saccade {
namespace {

constexpr std::int64_t shown_events_us = 10'000;  ///< age of the oldest event in an image
constexpr ImageSize scene_size{640, 480};

cv::Mat grey_image(const SimEye& eye) {
  const ImageSize size = eye.camera().size;
  cv::Mat grey;
  cv::Mat(size.height, size.width, CV_32F, const_cast<float*>(eye.image().data())).convertTo(grey, CV_8U);
  return grey;
}

void write_png(const std::filesystem::path& path, const cv::Mat& image) {
  const std::vector<unsigned char> png = encoded_image("png", image);
  OutputFile file(path);
  file.write(std::as_bytes(std::span(png)));
  file.commit();
}

}  // namespace

RunPictures::RunPictures(std::filesystem::path folder, const Scenario& scenario, SimRobot& robot,
                         const Loop& loop, const RunScores& scores)
    : folder_(std::move(folder)), scenario_(scenario), robot_(robot), loop_(loop), scores_(scores) {
  const auto duration_us = std::llround(scenario.run.duration_s * 1e6);
  for (std::int64_t i = 0; i < scenario.output.pictures; ++i) {
    const std::int64_t wanted_us = duration_us * (2 * i + 1) / (2 * scenario.output.pictures);
    still_times_us_.push_back(wanted_us / World::tick_us * World::tick_us);
  }
  if (!still_times_us_.empty()) std::filesystem::create_directories(folder_ / "frames");
  if (scenario.output.video)
    video_ = std::make_unique<VideoComposer>(folder_ / "video.mp4", scenario.output.video_speed);
}

RunPictures::~RunPictures() = default;

void RunPictures::on_tick(const Tick& tick) {
  if (!video_ && still_times_us_.empty()) return;
  const auto begin = std::chrono::steady_clock::now();
  keep_recent_events(tick);
  draw(tick);
  wall_s_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

void RunPictures::keep_recent_events(const Tick& tick) {
  std::ranges::copy_if(tick.events, std::back_inserter(recent_events_),
                       [](const Event& e) { return e.camera == 0; });
  std::erase_if(recent_events_, [&](const Event& e) { return e.t_us <= tick.t_us - shown_events_us; });
}

void RunPictures::draw(const Tick& tick) {
  const bool still = std::ranges::binary_search(still_times_us_, tick.t_us);
  const bool film = video_ && video_->is_due(tick.t_us);
  if (!still && !film) return;
  const cv::Mat grey = grey_image(robot_.left_eye());
  cv::Mat scene(scene_size.height, scene_size.width, CV_8UC3);
  robot_.draw_scene(profile_view(), scene_size,
                    std::span(scene.data, static_cast<std::size_t>(scene_size.pixels()) * 3));
  cv::cvtColor(scene, scene, cv::COLOR_RGB2BGR);
  if (still) write_stills(tick, grey, scene);
  if (film) add_video_frame(tick, grey, scene);
}

void RunPictures::write_stills(const Tick& tick, const cv::Mat& grey, const cv::Mat& scene) const {
  const std::filesystem::path frames = folder_ / "frames";
  write_png(frames / fmt::format("{:09}_eye.png", tick.t_us), grey);
  if (const SimEye* right = robot_.right_eye())
    write_png(frames / fmt::format("{:09}_right_eye.png", tick.t_us), grey_image(*right));
  write_png(frames / fmt::format("{:09}_scene.png", tick.t_us), scene);
  write_hough_spaces(tick.t_us);
}

void RunPictures::write_hough_spaces(std::int64_t t_us) const {
  const ImageSize size = scenario_.sim.camera.size;
  std::vector<float> response(static_cast<std::size_t>(size.pixels()));
  for (const LoopDetector& detector : loop_.detectors()) {
    if (!hough_space_of(*detector.detector, response)) continue;
    const float strongest = *std::max_element(response.begin(), response.end());
    write_png(folder_ / "frames" /
                  fmt::format("{:09}_{}_hough_{:.4g}.png", t_us, file_part(detector.name), strongest),
              response_image(response, size));
  }
}

void RunPictures::add_video_frame(const Tick& tick, const cv::Mat& grey, const cv::Mat& scene) {
  const Camera& camera = scenario_.sim.camera;
  AnnotatedImage eye;
  eye.size = camera.size;
  eye.grey = grey;
  eye.events = recent_events_;
  const EyeTruth& truth = robot_.truth().left;
  if (truth.visible > 0.0) eye.truth = truth.circle;
  for (std::size_t i = 0; i < tick.detectors.size(); ++i) {
    const DetectorTick& result = tick.detectors[i];
    if (!result.at_threshold) continue;
    eye.detections.push_back(
        {result.estimate.circle, loop_.detectors()[i].name, detector_colour(loop_.detectors()[i].name)});
  }
  eye.principal_px = Eigen::Vector2d(camera.cx_px, camera.cy_px);
  if (tick.target_m) eye.target_px = camera.project(truth.root_from_cam.inverse() * *tick.target_m);
  const double speed = scenario_.output.video_speed;
  video_->add(scene, eye,
              fmt::format("{}   t {:.{}f} s   gaze error {:.1f} deg{}", scenario_.name,
                          static_cast<double>(tick.t_us) * 1e-6, speed == 1.0 ? 2 : 3,
                          scores_.fixation_error_rad() * 180.0 / std::numbers::pi,
                          speed == 1.0 ? "" : fmt::format("   {:g} x real time", speed)));
}

void RunPictures::commit() {
  if (video_) video_->commit();
}

}  // namespace saccade
