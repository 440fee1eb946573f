#include "evaluation/replay/foxglove_file.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>

#include "core/error.h"
#include "evaluation/replay/foxglove_scene.h"
#include "evaluation/replay/foxglove_track.h"
#include "evaluation/report/run_data.h"
#include "evaluation/scoring/metrics.h"
#include "recording/event_file.h"
#include "recording/run_file_names.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// How old a row may be whose circle or gaze an image shows.
constexpr std::int64_t shown_us = 10'000;

/// What an image of events is annotated with, at the image's own time: the true circle, those of the detectors at or above their
/// thresholds, and of the left eye the optical axis and the gaze target.
class CircleTrack final : public FoxgloveTrack {
 public:
  CircleTrack(const fs::path& folder, const Metrics& metrics, int camera, const DetectorScores& detectors,
              ImageInstants instants, FoxgloveWriter& writer)
      : instants_(instants),
        camera_(camera == 0 ? metrics.camera : std::nullopt),
        truth_(folder / (is_second(metrics, camera) ? run_file::truth_right : run_file::truth)),
        detections_(folder /
                    (is_second(metrics, camera) ? run_file::detections_right : run_file::detections)),
        gaze_(folder / run_file::gaze),
        eye_(folder / run_file::eye),
        writer_(writer),
        topic_(writer.add("/" + side_of(camera) + "/circles", "foxglove.ImageAnnotations")) {
    for (const auto& [name, score] : detectors) detectors_.push_back({name, score.threshold, {}});
  }

  /// Whether the tables of this camera are those of the second one of a run with two.
  static bool is_second(const Metrics& metrics, int camera) { return camera == 1 && metrics.right_eye; }

  std::optional<std::int64_t> next_us() override { return instants_.next_us(); }
  void write() override {
    const std::int64_t t_us = *instants_.next_us();
    instants_.go_on();
    while (detections_.next() && detections_.next()->t_us <= t_us) {
      const DetectionRow row = detections_.take();
      for (Detector& detector : detectors_) {
        if (detector.name == row.detector) detector.newest = row;
      }
    }
    Json circles = Json::array();
    const TruthRow* const truth = truth_.newest(t_us, shown_us);
    if (truth != nullptr && truth->visible > 0.0)
      circles.push_back(circle(t_us, truth->circle, truth_colour, thick_px));
    for (const Detector& detector : detectors_) {
      const auto& row = detector.newest;
      if (row && t_us - row->t_us <= shown_us && row->score >= detector.threshold)
        circles.push_back(
            circle(t_us, row->circle, detector_colour(detector.name), row->held ? thin_px : thick_px));
    }
    writer_.write(topic_, t_us,
                  {{"circles", std::move(circles)}, {"points", gaze_marks(t_us)}, {"texts", Json::array()}});
  }

 private:
  static constexpr double thick_px = 0.8;
  static constexpr double thin_px = 0.3;

  struct Detector {
    std::string name;
    double threshold;
    std::optional<DetectionRow> newest;
  };

  /// Foxglove's (0, 0) is the corner of the top left pixel, ours its centre.
  static Json point(double x_px, double y_px) { return {{"x", x_px + 0.5}, {"y", y_px + 0.5}}; }

  static Json circle(std::int64_t t_us, const Circle& c, Colour colour, double thickness_px) {
    return {{"timestamp", foxglove_time(t_us)},
            {"position", point(c.x_px, c.y_px)},
            {"diameter", 2.0 * c.r_px},
            {"thickness", thickness_px},
            {"fill_color", foxglove_colour(colour, 0.0)},
            {"outline_color", foxglove_colour(colour)}};
  }

  static Json marks(std::int64_t t_us, int type, Json points, Colour colour) {
    return {{"timestamp", foxglove_time(t_us)},
            {"type", type},
            {"points", std::move(points)},
            {"outline_color", foxglove_colour(colour)},
            {"outline_colors", Json::array()},
            {"fill_color", foxglove_colour(colour, 0.0)},
            {"thickness", thick_px}};
  }

  Json gaze_marks(std::int64_t t_us) {
    constexpr int loop = 2;
    constexpr int lines = 4;
    Json list = Json::array();
    if (!camera_) return list;
    const GazeRow* const gaze = gaze_.newest(t_us, shown_us);
    const EyeRow* const eye = eye_.newest(t_us, shown_us);
    if (gaze == nullptr || eye == nullptr) return list;
    const double arm = 1.0 + 0.02 * camera_->size.width;
    const double x = camera_->cx_px;
    const double y = camera_->cy_px;
    Json cross = {point(x - arm, y), point(x + arm, y), point(x, y - arm), point(x, y + arm)};
    list.push_back(marks(t_us, lines, std::move(cross), gaze_colour));
    if (!gaze->target_m.allFinite()) return list;
    const auto target = camera_->project(eye->root_from_left_cam().inverse() * gaze->target_m);
    if (!target) return list;
    Json diamond = {point(target->x() + arm, target->y()), point(target->x(), target->y() + arm),
                    point(target->x() - arm, target->y()), point(target->x(), target->y() - arm)};
    list.push_back(marks(t_us, loop, std::move(diamond), gaze_target_colour));
    return list;
  }

  ImageInstants instants_;
  std::optional<Camera> camera_;
  TableCursor<TruthRow> truth_;
  TableCursor<DetectionRow> detections_;
  TableCursor<GazeRow> gaze_;
  TableCursor<EyeRow> eye_;
  FoxgloveWriter& writer_;
  std::size_t topic_;
  std::vector<Detector> detectors_;
};

/// Poses of the bodies that move and of the left camera: at the times that the scene has, else every 10 ms.
class TransformTrack final : public FoxgloveTrack {
 public:
  TransformTrack(const fs::path& folder, const FoxgloveScene& scene, const ImageInstants& run,
                 FoxgloveWriter& writer)
      : scene_(scene),
        times_(scene.times()),
        eye_(folder / run_file::eye),
        writer_(writer),
        topic_(writer.add("/tf", "foxglove.FrameTransforms")) {
    constexpr std::int64_t step_ms = 10;
    if (!times_.empty()) return;
    for (std::int64_t ms = step_ms; ms <= run.end_ms(); ms += step_ms) times_.push_back(run.time_us(ms));
  }

  std::optional<std::int64_t> next_us() override {
    return next_ < times_.size() ? std::optional(times_[next_]) : std::nullopt;
  }
  void write() override {
    const std::int64_t t_us = times_[next_++];
    Json transforms = scene_.transforms(t_us);
    if (const EyeRow* const eye = eye_.newest(t_us, shown_us)) {
      const Eigen::Isometry3d pose = eye->root_from_left_cam();
      transforms.push_back({{"timestamp", foxglove_time(t_us)},
                            {"parent_frame_id", scene_.root()},
                            {"child_frame_id", frame_of(0)},
                            {"translation", foxglove_vector(pose.translation())},
                            {"rotation", foxglove_quaternion(Eigen::Quaterniond(pose.linear()))}});
    }
    writer_.write(topic_, t_us, {{"transforms", std::move(transforms)}});
  }

 private:
  const FoxgloveScene& scene_;
  std::vector<std::int64_t> times_;
  std::size_t next_ = 0;
  TableCursor<EyeRow> eye_;
  FoxgloveWriter& writer_;
  std::size_t topic_;
};

/// The left eye's axis to the fixation point, and the gaze target, in the scene; at the times of the images.
class GazeLineTrack final : public FoxgloveTrack {
 public:
  GazeLineTrack(const fs::path& folder, std::string root, ImageInstants instants, FoxgloveWriter& writer)
      : root_(std::move(root)),
        instants_(instants),
        gaze_(folder / run_file::gaze),
        eye_(folder / run_file::eye),
        writer_(writer),
        topic_(writer.add("/gaze/scene", "foxglove.SceneUpdate")) {}

  std::optional<std::int64_t> next_us() override { return instants_.next_us(); }
  void write() override {
    constexpr double radius_m = 0.013;
    constexpr double line_m = 0.004;
    const std::int64_t t_us = *instants_.next_us();
    instants_.go_on();
    Json entity = foxglove_entity(t_us, root_, "gaze");
    const GazeRow* const gaze = gaze_.newest(t_us, shown_us);
    const EyeRow* const eye = eye_.newest(t_us, shown_us);
    const Json at_origin = foxglove_pose(Eigen::Isometry3d::Identity());
    if (gaze != nullptr && eye != nullptr && gaze->fixation_m.allFinite()) {
      entity["lines"].push_back(
          {{"type", 0},
           {"pose", at_origin},
           {"thickness", line_m},
           {"scale_invariant", false},
           {"points", Json::array({foxglove_vector(eye->position_m), foxglove_vector(gaze->fixation_m)})},
           {"color", foxglove_colour(gaze_colour)},
           {"colors", Json::array()},
           {"indices", Json::array()}});
    }
    if (gaze != nullptr && gaze->target_m.allFinite()) {
      Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
      pose.translation() = gaze->target_m;
      entity["spheres"].push_back({{"pose", foxglove_pose(pose)},
                                   {"size", foxglove_vector(Eigen::Vector3d::Constant(2.0 * radius_m))},
                                   {"color", foxglove_colour(gaze_target_colour)}});
    }
    writer_.write(topic_, t_us,
                  {{"deletions", Json::array()}, {"entities", Json::array({std::move(entity)})}});
  }

 private:
  std::string root_;
  ImageInstants instants_;
  TableCursor<GazeRow> gaze_;
  TableCursor<EyeRow> eye_;
  FoxgloveWriter& writer_;
  std::size_t topic_;
};

/// One message at the start of the run.
class FirstMessage final : public FoxgloveTrack {
 public:
  FirstMessage(std::int64_t t_us, std::size_t topic, Json message, FoxgloveWriter& writer)
      : t_us_(t_us), topic_(topic), message_(std::move(message)), writer_(writer) {}

  std::optional<std::int64_t> next_us() override { return t_us_; }
  void write() override {
    writer_.write(topic_, *t_us_, message_);
    t_us_.reset();
  }

 private:
  std::optional<std::int64_t> t_us_;
  std::size_t topic_;
  Json message_;
  FoxgloveWriter& writer_;
};

Json calibration(std::int64_t t_us, const std::string& frame, const Camera& c) {
  const bool is_fisheye = c.lens == LensModel::fisheye;
  const Json distortion =
      is_fisheye ? Json::array({c.k1, c.k2, c.k3, c.k4}) : Json::array({c.k1, c.k2, c.p1, c.p2, c.k3});
  return {{"timestamp", foxglove_time(t_us)},
          {"frame_id", frame},
          {"width", c.size.width},
          {"height", c.size.height},
          {"distortion_model", is_fisheye ? "kannala_brandt" : "plumb_bob"},
          {"D", distortion},
          {"K", Json::array({c.fx_px, 0.0, c.cx_px, 0.0, c.fy_px, c.cy_px, 0.0, 0.0, 1.0})},
          {"R", Json::array({1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0})},
          {"P", Json::array({c.fx_px, 0.0, c.cx_px, 0.0, 0.0, c.fy_px, c.cy_px, 0.0, 0.0, 0.0, 1.0, 0.0})}};
}

/// The tracks of a run folder.
class Tracks {
 public:
  Tracks(const fs::path& folder, const FoxgloveScene& scene, const Metrics& metrics,
         const ImageInstants& instants, FoxgloveWriter& writer)
      : folder_(folder), scene_(scene), metrics_(metrics), instants_(instants), writer_(writer) {}

  void add_all(std::unique_ptr<EventReader> reader, FoxgloveSummary& summary) {
    const int first = metrics_.events_camera.value_or(0);
    std::set<std::uint8_t> cameras = {static_cast<std::uint8_t>(first)};
    if (metrics_.right_eye) cameras.insert(1);
    add_scene();
    if (metrics_.camera) add_calibration(first, *metrics_.camera);
    if (metrics_.right_eye) add_calibration(1, metrics_.right_eye->camera);
    tracks_.push_back(event_track(metrics_, instants_, std::move(reader), cameras, writer_, summary));
    add_circles(first, metrics_.detectors, run_file::truth, run_file::detections);
    if (metrics_.right_eye)
      add_circles(1, metrics_.right_eye->detectors, run_file::truth_right, run_file::detections_right);
    if (has(run_file::gaze) || has(run_file::eye)) {
      tracks_.push_back(gaze_track(folder_, metrics_, writer_));
      add<GazeLineTrack>(folder_, scene_.root(), instants_, writer_);
    }
    if (has(run_file::imu)) tracks_.push_back(imu_track(folder_ / run_file::imu, writer_));
    if (auto track = ground_truth_track(folder_, writer_)) tracks_.push_back(std::move(track));
  }

  void write() {
    while (FoxgloveTrack* const track = earliest()) track->write();
  }

 private:
  template <class Track, class... Arguments>
  void add(Arguments&&... arguments) {
    tracks_.push_back(std::make_unique<Track>(std::forward<Arguments>(arguments)...));
  }
  [[nodiscard]] bool has(const char* name) const { return fs::exists(folder_ / name); }

  void add_scene() {
    const std::int64_t t_us = metrics_.start_us;
    const auto add_first = [&](const char* topic, const char* schema, Json message) {
      add<FirstMessage>(t_us, writer_.add(topic, schema), std::move(message), writer_);
    };
    if (!scene_.empty()) {
      const Json still = {{"transforms", scene_.still_transforms(t_us)}};
      add_first("/tf_static", "foxglove.FrameTransforms", still);
      add_first("/scene", "foxglove.SceneUpdate", scene_.shapes(t_us));
      add_first("/room", "foxglove.SceneUpdate", scene_.room(t_us));
    }
    if (!scene_.empty() || has(run_file::eye)) add<TransformTrack>(folder_, scene_, instants_, writer_);
  }

  void add_calibration(int camera, const Camera& lens) {
    const std::size_t topic =
        writer_.add("/" + side_of(camera) + "/calibration", "foxglove.CameraCalibration");
    add<FirstMessage>(metrics_.start_us, topic, calibration(metrics_.start_us, frame_of(camera), lens),
                      writer_);
  }

  void add_circles(int camera, const DetectorScores& detectors, const char* truth, const char* detections) {
    if (!has(truth) && !has(detections)) return;
    add<CircleTrack>(folder_, metrics_, camera, detectors, instants_, writer_);
    if (has(truth)) tracks_.push_back(truth_track(folder_ / truth, camera, writer_));
    if (has(detections))
      tracks_.push_back(detection_track(folder_ / detections, folder_ / truth, camera, detectors, writer_));
  }

  /// Of the tracks with the earliest messages the first; null at the end.
  FoxgloveTrack* earliest() {
    FoxgloveTrack* found = nullptr;
    std::int64_t found_us = std::numeric_limits<std::int64_t>::max();
    for (const auto& track : tracks_) {
      const std::optional<std::int64_t> next = track->next_us();
      if (next && *next < found_us) {
        found = track.get();
        found_us = *next;
      }
    }
    return found;
  }

  fs::path folder_;
  const FoxgloveScene& scene_;
  const Metrics& metrics_;
  const ImageInstants& instants_;
  FoxgloveWriter& writer_;
  std::vector<std::unique_ptr<FoxgloveTrack>> tracks_;
};

}  // namespace

std::string side_of(int camera) { return camera == 0 ? "left" : "right"; }
std::string frame_of(int camera) { return side_of(camera) + "_camera"; }

FoxgloveSummary write_foxglove(const fs::path& run_folder, const FormatRegistry& formats, double images_hz,
                               const fs::path& file) {
  SACCADE_CHECK(images_hz > 0.0 && images_hz <= 1000.0);
  const Metrics metrics = read_metrics(run_folder / run_file::metrics);
  if (metrics.events_file.empty() || metrics.image.pixels() <= 0)
    throw InputError(run_folder.string(), "a run without events", "a run with an event file");
  std::unique_ptr<EventReader> reader = open_event_file(formats, run_folder / metrics.events_file);
  const FoxgloveScene scene(run_folder / run_file::scene);
  const ImageInstants instants(metrics, images_hz);
  FoxgloveSummary summary;
  OutputFile out(file);
  FoxgloveWriter writer(out);
  Tracks tracks(run_folder, scene, metrics, instants, writer);
  tracks.add_all(std::move(reader), summary);
  tracks.write();
  if (summary.events == 0)
    throw InputError(run_folder.string(), "no events in the time of the run", "a run with events");
  writer.finish();
  out.commit();
  summary.messages = writer.messages();
  return summary;
}

}  // namespace saccade
