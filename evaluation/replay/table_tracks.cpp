#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "core/units.h"
#include "evaluation/replay/foxglove_track.h"
#include "evaluation/scoring/eye_movement.h"
#include "head/head_model.h"
#include "recording/run_file_names.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// A number of a message, left out where it does not apply.
void put(Json& message, const std::string& name, double value) {
  if (std::isfinite(value)) message[name] = value;
}
void put(Json& message, const std::string& name, const Eigen::Vector3d& value) {
  if (value.allFinite()) message[name] = foxglove_vector(value);
}

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

class DetectionTrack final : public FoxgloveTrack {
 public:
  DetectionTrack(const fs::path& table, const fs::path& truth, int camera, const DetectorScores& detectors,
                 FoxgloveWriter& writer)
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

}  // namespace

std::unique_ptr<FoxgloveTrack> truth_track(const fs::path& table, int camera, FoxgloveWriter& writer) {
  return std::make_unique<TruthTrack>(table, camera, writer);
}

std::unique_ptr<FoxgloveTrack> detection_track(const fs::path& table, const fs::path& truth, int camera,
                                               const DetectorScores& detectors, FoxgloveWriter& writer) {
  return std::make_unique<DetectionTrack>(table, truth, camera, detectors, writer);
}

std::unique_ptr<FoxgloveTrack> gaze_track(const fs::path& run_folder, const Metrics& metrics,
                                          FoxgloveWriter& writer) {
  return std::make_unique<GazeTrack>(run_folder, metrics, writer);
}

std::unique_ptr<FoxgloveTrack> imu_track(const fs::path& table, FoxgloveWriter& writer) {
  return std::make_unique<ImuTrack>(table, writer);
}

}  // namespace saccade
