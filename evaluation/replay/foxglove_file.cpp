#include "evaluation/replay/foxglove_file.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "core/error.h"
#include "core/units.h"
#include "evaluation/replay/foxglove_scene.h"
#include "evaluation/replay/foxglove_track.h"
#include "evaluation/report/overlay.h"
#include "evaluation/report/run_data.h"
#include "evaluation/scoring/eye_movement.h"
#include "evaluation/scoring/metrics.h"
#include "head/head_model.h"
#include "recording/event_file.h"
#include "recording/run_file_names.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// How old a row may be whose circle or gaze an image shows.
constexpr std::int64_t shown_us = 10'000;

std::string side_of(int camera) { return camera == 0 ? "left" : "right"; }
std::string frame_of(int camera) { return side_of(camera) + "_camera"; }

/// The instants of the images of a run, which are whole ms: number k shows the events after that of k - 1 up to its own.
class ImageInstants {
 public:
  ImageInstants(const Metrics& metrics, double images_hz)
      : start_us_(metrics.start_us),
        end_ms_(
            std::max<std::int64_t>(1, static_cast<std::int64_t>(std::ceil(metrics.duration_s * 1e3 - 1e-6)))),
        images_hz_(images_hz) {
    go_on();
  }

  [[nodiscard]] std::int64_t start_us() const { return start_us_; }
  [[nodiscard]] std::int64_t end_ms() const { return end_ms_; }
  [[nodiscard]] std::int64_t time_us(std::int64_t ms) const { return start_us_ + 1000 * ms; }
  /// The next one, ms after the start; none after the end of the run, where the last one is.
  [[nodiscard]] std::optional<std::int64_t> next_ms() const { return next_ms_; }
  [[nodiscard]] std::optional<std::int64_t> next_us() const {
    return next_ms_ ? std::optional(time_us(*next_ms_)) : std::nullopt;
  }
  void go_on() {
    const std::int64_t last_ms = next_ms_.value_or(0);
    next_ms_.reset();
    if (last_ms == end_ms_) return;
    const double ms = static_cast<double>(++number_) * 1e3 / images_hz_;
    next_ms_ = std::min(end_ms_, static_cast<std::int64_t>(std::llround(ms)));
  }

 private:
  std::int64_t start_us_;
  std::int64_t end_ms_;
  double images_hz_;
  std::int64_t number_ = 0;
  std::optional<std::int64_t> next_ms_;
};

/// The events of a file by the millisecond that they end in. An event may follow ones that are up to 100 ms newer.
class EventsByMs {
 public:
  EventsByMs(std::unique_ptr<EventReader> reader, const ImageInstants& run, std::set<std::uint8_t> cameras)
      : reader_(std::move(reader)),
        start_us_(run.start_us()),
        end_ms_(run.end_ms()),
        cameras_(std::move(cameras)) {}

  /// The events of (ms - 1, ms] after the start, in the first one those at the start too; sorted by time. `ms` grows.
  std::vector<Event> take(std::int64_t ms) {
    constexpr std::int64_t slack_ms = 100;
    while (!at_end_ && newest_ms_ <= ms + slack_ms) read();
    taken_ms_ = ms;
    std::vector<Event> events;
    if (const auto place = by_ms_.find(ms); place != by_ms_.end()) {
      events = std::move(place->second);
      by_ms_.erase(place);
    }
    std::ranges::stable_sort(events, {}, &Event::t_us);
    return events;
  }
  [[nodiscard]] std::int64_t late() const { return late_; }

 private:
  void read() {
    constexpr std::size_t block_events = 65'536;
    block_.clear();
    at_end_ = reader_->read(block_, block_events) == 0;
    for (const Event& event : block_) {
      if (event.t_us < start_us_ || !cameras_.contains(event.camera)) continue;
      const std::int64_t ms = std::max<std::int64_t>(1, (event.t_us - start_us_ + 999) / 1000);
      if (ms > end_ms_) continue;  // of a recording that was not processed to its end
      newest_ms_ = std::max(newest_ms_, ms);
      if (ms <= taken_ms_)
        ++late_;
      else
        by_ms_[ms].push_back(event);
    }
  }

  std::unique_ptr<EventReader> reader_;
  std::int64_t start_us_;
  std::int64_t end_ms_;
  std::set<std::uint8_t> cameras_;
  std::vector<Event> block_;
  std::map<std::int64_t, std::vector<Event>> by_ms_;
  std::int64_t newest_ms_ = 0;
  std::int64_t taken_ms_ = 0;
  std::int64_t late_ = 0;
  bool at_end_ = false;
};

/// Images of the events, and how many there were in each ms.
class EventTrack final : public FoxgloveTrack {
 public:
  EventTrack(const Metrics& metrics, ImageInstants instants, std::unique_ptr<EventReader> reader,
             const std::set<std::uint8_t>& cameras, FoxgloveWriter& writer, FoxgloveSummary& summary)
      : size_(metrics.image),
        instants_(instants),
        events_(std::move(reader), instants, cameras),
        writer_(writer),
        summary_(summary) {
    for (const std::uint8_t camera : cameras) {
      const std::string side = "/" + side_of(camera);
      sides_.push_back(
          {camera,
           writer.add(side + "/events", "foxglove.CompressedImage"),
           writer.add_plain(side + "/event_counts", "saccade.EventCounts", {{"on_per_ms"}, {"off_per_ms"}}),
           {}});
    }
  }

  std::optional<std::int64_t> next_us() override {
    return ms_ <= instants_.end_ms() ? std::optional(instants_.time_us(ms_)) : std::nullopt;
  }
  void write() override {
    const std::vector<Event> events = events_.take(ms_);
    const std::int64_t t_us = instants_.time_us(ms_);
    const bool is_instant = instants_.next_ms() == ms_;
    for (Side& side : sides_) {
      std::int64_t on = 0;
      const std::size_t before = side.events.size();
      for (const Event& event : events) {
        if (event.camera != side.camera) continue;
        side.events.push_back(event);
        on += event.on ? 1 : 0;
      }
      const auto count = static_cast<std::int64_t>(side.events.size() - before);
      summary_.events += count;
      writer_.write(side.counts, t_us,
                    {{"timestamp", foxglove_time(t_us)}, {"on_per_ms", on}, {"off_per_ms", count - on}});
      if (is_instant) write_image(side, t_us);
    }
    summary_.late_events = events_.late();
    if (is_instant) instants_.go_on();
    ++ms_;
  }

 private:
  struct Side {
    std::uint8_t camera;
    std::size_t images;
    std::size_t counts;
    std::vector<Event> events;  ///< since the last image
  };

  void write_image(Side& side, std::int64_t t_us) {
    AnnotatedImage image;
    image.size = size_;
    image.events = side.events;
    writer_.write(side.images, t_us, foxglove_png(t_us, frame_of(side.camera), draw_image(image, 1)));
    side.events.clear();
  }

  ImageSize size_;
  ImageInstants instants_;
  EventsByMs events_;
  FoxgloveWriter& writer_;
  FoxgloveSummary& summary_;
  std::vector<Side> sides_;
  std::int64_t ms_ = 1;
};

/// What an image of events is annotated with, at the image's own time: the true circle, those of the detectors at or above their
/// thresholds, and of the left eye the optical axis and the gaze target.
class CircleTrack final : public FoxgloveTrack {
 public:
  CircleTrack(const fs::path& folder, const Metrics& metrics, int camera,
              const std::vector<std::pair<std::string, DetectorScore>>& detectors, ImageInstants instants,
              FoxgloveWriter& writer)
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

/// A number of a message, left out where it does not apply.
void put(Json& message, const std::string& name, double value) {
  if (std::isfinite(value)) message[name] = value;
}
void put(Json& message, const std::string& name, const Eigen::Vector3d& value) {
  if (value.allFinite()) message[name] = foxglove_vector(value);
}

/// truth.csv
class TruthTrack final : public FoxgloveTrack {
 public:
  TruthTrack(const fs::path& table, int camera, FoxgloveWriter& writer)
      : truth_(table),
        writer_(writer),
        topic_(writer.add_plain(
            "/" + side_of(camera) + "/truth", "saccade.Truth",
            {{"x_px"}, {"y_px"}, {"r_px"}, {"visible"}, {"position_m", PlainMember::Kind::vector}})) {}

  std::optional<std::int64_t> next_us() override { return truth_.next_us(); }
  void write() override {
    const TruthRow row = truth_.take();
    Json message = {{"timestamp", foxglove_time(row.t_us)}};
    put(message, "x_px", row.circle.x_px);
    put(message, "y_px", row.circle.y_px);
    put(message, "r_px", row.circle.r_px);
    put(message, "visible", row.visible);
    put(message, "position_m", row.position_m);
    writer_.write(topic_, row.t_us, message);
  }

 private:
  TableCursor<TruthRow> truth_;
  FoxgloveWriter& writer_;
  std::size_t topic_;
};

/// detections.csv, a topic for each detector, with the distance to the true circle's centre where it is known.
class DetectionTrack final : public FoxgloveTrack {
 public:
  DetectionTrack(const fs::path& table, const fs::path& truth, int camera,
                 const std::vector<std::pair<std::string, DetectorScore>>& detectors, FoxgloveWriter& writer)
      : detections_(table), truth_(truth), writer_(writer) {
    for (const auto& [name, score] : detectors) {
      topics_[name] = writer.add_plain(
          "/" + side_of(camera) + "/detections/" + name, "saccade.Detection",
          {{"x_px"}, {"y_px"}, {"r_px"}, {"score"}, {"held", PlainMember::Kind::truth_value}, {"error_px"}});
    }
  }

  std::optional<std::int64_t> next_us() override { return detections_.next_us(); }
  void write() override {
    const DetectionRow row = detections_.take();
    const auto topic = topics_.find(row.detector);
    if (topic == topics_.end()) return;
    Json message = {{"timestamp", foxglove_time(row.t_us)}};
    put(message, "x_px", row.circle.x_px);
    put(message, "y_px", row.circle.y_px);
    put(message, "r_px", row.circle.r_px);
    put(message, "score", row.score);
    message["held"] = row.held;
    const TruthRow* const truth = truth_.newest(row.t_us, 0);
    if (truth != nullptr && truth->visible > 0.0)
      put(message, "error_px",
          std::hypot(row.circle.x_px - truth->circle.x_px, row.circle.y_px - truth->circle.y_px));
    writer_.write(topic->second, row.t_us, message);
  }

 private:
  TableCursor<DetectionRow> detections_;
  TableCursor<TruthRow> truth_;
  FoxgloveWriter& writer_;
  std::map<std::string, std::size_t> topics_;  ///< by detector
};

/// gaze.csv and eye.csv: fixation point, target, the left eye's angle off the ball, the joints.
class GazeTrack final : public FoxgloveTrack {
 public:
  GazeTrack(const fs::path& folder, const Metrics& metrics, FoxgloveWriter& writer)
      : gaze_(folder / run_file::gaze),
        eye_(folder / run_file::eye),
        truth_(folder / run_file::truth),
        writer_(writer),
        topic_(writer.add_plain("/gaze", "saccade.Gaze",
                                {{"error_deg"},
                                 {"fixation_m", PlainMember::Kind::vector},
                                 {"target_m", PlainMember::Kind::vector}})) {
    if (!metrics.gaze || !metrics.gaze->limits.head) return;
    std::vector<PlainMember> members;
    for (const HeadJoint& joint : metrics.gaze->limits.head->joints) {
      joints_.push_back({joint.name + "_deg", joint.slot});
      members.push_back({joints_.back().name});
    }
    joint_topic_ = writer.add_plain("/joints", "saccade.Joints", members);
  }

  std::optional<std::int64_t> next_us() override {
    const auto gaze = gaze_.next_us();
    const auto eye = eye_.next_us();
    return gaze && eye ? std::min(gaze, eye) : gaze ? gaze : eye;
  }
  void write() override {
    const std::int64_t t_us = *next_us();
    const GazeRow* const gaze = gaze_.newest(t_us, 0);
    const EyeRow* const eye = eye_.newest(t_us, 0);
    const TruthRow* const ball = truth_.newest(t_us, 0);
    Json message = {{"timestamp", foxglove_time(t_us)}};
    if (eye != nullptr && ball != nullptr && ball->position_m.allFinite()) {
      put(message, "error_deg",
          angle_deg(eye->root_from_left_cam().linear().col(2), ball->position_m - eye->position_m));
    }
    if (gaze != nullptr) {
      put(message, "fixation_m", gaze->fixation_m);
      put(message, "target_m", gaze->target_m);
    }
    writer_.write(topic_, t_us, message);
    if (gaze == nullptr || !joint_topic_) return;
    Json joints = {{"timestamp", foxglove_time(t_us)}};
    for (const Joint& joint : joints_) put(joints, joint.name, gaze->position_rad[joint.slot] * deg_per_rad);
    writer_.write(*joint_topic_, t_us, joints);
  }

 private:
  struct Joint {
    std::string name;
    int slot;
  };
  TableCursor<GazeRow> gaze_;
  TableCursor<EyeRow> eye_;
  TableCursor<TruthRow> truth_;
  FoxgloveWriter& writer_;
  std::size_t topic_;
  std::vector<Joint> joints_;
  std::optional<std::size_t> joint_topic_;
};

/// imu.csv
class ImuTrack final : public FoxgloveTrack {
 public:
  ImuTrack(const fs::path& table, FoxgloveWriter& writer)
      : imu_(table),
        writer_(writer),
        topic_(writer.add_plain("/imu", "saccade.Imu",
                                {{"angular_velocity_rad_s", PlainMember::Kind::vector},
                                 {"acceleration_m_s2", PlainMember::Kind::vector}})) {}

  std::optional<std::int64_t> next_us() override { return imu_.next_us(); }
  void write() override {
    const ImuRow row = imu_.take();
    Json message = {{"timestamp", foxglove_time(row.t_us)}};
    put(message, "angular_velocity_rad_s", row.reading.angular_velocity_rad_s);
    put(message, "acceleration_m_s2", row.reading.acceleration_m_s2);
    writer_.write(topic_, row.t_us, message);
  }

 private:
  TableCursor<ImuRow> imu_;
  FoxgloveWriter& writer_;
  std::size_t topic_;
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
      is_fisheye ? Json::array({c.k1, c.k2, c.k3, c.k4}) : Json::array({c.k1, c.k2, c.p1, c.p2, 0.0});
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
    add<EventTrack>(metrics_, instants_, std::move(reader), cameras, writer_, summary);
    add_circles(first, metrics_.detectors, run_file::truth, run_file::detections);
    if (metrics_.right_eye)
      add_circles(1, metrics_.right_eye->detectors, run_file::truth_right, run_file::detections_right);
    if (has(run_file::gaze) || has(run_file::eye)) {
      add<GazeTrack>(folder_, metrics_, writer_);
      add<GazeLineTrack>(folder_, scene_.root(), instants_, writer_);
    }
    if (has(run_file::imu)) add<ImuTrack>(folder_ / run_file::imu, writer_);
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

  void add_circles(int camera, const std::vector<std::pair<std::string, DetectorScore>>& detectors,
                   const char* truth, const char* detections) {
    if (!has(truth) && !has(detections)) return;
    add<CircleTrack>(folder_, metrics_, camera, detectors, instants_, writer_);
    if (has(truth)) add<TruthTrack>(folder_ / truth, camera, writer_);
    if (has(detections))
      add<DetectionTrack>(folder_ / detections, folder_ / truth, camera, detectors, writer_);
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
