#pragma once

#include <cstdint>
#include <string>

#include "core/config.h"
#include "robot/event_timeline.h"

namespace saccade {

/// The event ports of one or both cameras.
struct YarpCameraConfig {
  std::string port = "/zynqGrabber/AE:o";
  std::string right_port;
  std::string carrier = "fast_tcp";
  std::string format = "packet";
  std::string codec = "ev2";
  std::int64_t stamp_bits = 30;
  std::int64_t width_px = 128;
  std::int64_t height_px = 128;
  bool swap_xy = false;
  bool flip_x = false;
  bool flip_y = false;
  bool swap_polarity = false;
  std::int64_t queue_events = 100'000;
};

/// The control of the head.
struct YarpHeadConfig {
  std::string control = "joints";
  std::string part = "/icub/head";
  std::string torso_part;
  std::string carrier = "fast_tcp";
};

/// The gaze controller of the robot and its settings while it is in use. The defaults are those recommended for heads that
/// oscillate.
struct YarpGazeConfig {
  std::string name = "/iKinGazeCtrl";
  double target_interval_ms = 75.0;
  double neck_time_s = 0.8;
  double eyes_time_s = 0.4;
  bool tracking = false;
  bool saccades = false;
  bool bind_roll = true;
};

/// The inertial sensor in the head.
struct YarpImuConfig {
  std::string port;  ///< empty: none
  std::string carrier = "fast_tcp";
};

/// A robot on a YARP network. The address of the name server is configured in YARP (`yarp conf`).
struct YarpConfig {
  std::string local = "/saccade";
  double timeout_s = 2.0;
  YarpCameraConfig camera;
  YarpHeadConfig head;
  YarpGazeConfig gaze_server;
  YarpImuConfig imu;
};

/// Keys: local, timeout_s, camera.{port, right_port, carrier, format, codec, stamp_bits, width_px, height_px, swap_xy,
/// flip_x, flip_y, swap_polarity, queue_events}, head.{control, part, torso_part, carrier}, gaze_server.{name, target_interval_ms,
/// neck_time_s, eyes_time_s, tracking, saccades, bind_roll}, imu.{port, carrier}.
void describe(FieldVisitor& v, YarpConfig& config);

/// Whether targets go to the gaze controller of the robot (`head.control: gaze`).
[[nodiscard]] inline bool has_gaze_controller(const YarpConfig& config) {
  return config.head.control == "gaze";
}

/// The part or gaze controller that moves the head; empty with `head.control: none`.
[[nodiscard]] std::string head_name(const YarpConfig& config);

[[nodiscard]] EventTimelineConfig timeline_config(const YarpCameraConfig& config);

}  // namespace saccade
