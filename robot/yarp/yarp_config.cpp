#include "robot/yarp/yarp_config.h"

#include <algorithm>

#include "recording/address_event.h"

namespace saccade {
namespace {

const std::vector<std::string> carriers = {"tcp", "fast_tcp", "udp", "unix_stream", "shmem"};

void port_name(FieldVisitor& v, std::string_view key, std::string& name, bool may_be_empty,
               std::string_view doc) {
  v.text(key, name, doc);
  const bool named = name.size() > 1 && name.front() == '/' && name.back() != '/' &&
                     name.find_first_of(" \t@") == std::string::npos;
  v.require(named || (may_be_empty && name.empty()), key, name, "a YARP name like /icub/head");
}

template <class Value>
Value value_of(const std::vector<std::string>& names, const std::string& name) {
  const auto it = std::find(names.begin(), names.end(), name);
  SACCADE_CHECK(it != names.end());
  return static_cast<Value>(it - names.begin());
}

void describe_camera(FieldVisitor& v, YarpCameraConfig& config) {
  port_name(
      v, "port", config.port, false,
      "port of the events; with right_port only those of the left eye, else of both eyes, as marked in each "
      "event");
  port_name(v, "right_port", config.right_port, true, "port of the right eye's events; empty: none");
  v.choice("carrier", config.carrier, carriers, "YARP carrier of the events");
  v.choice("format", config.format, packet_format_names(),
           "format of the messages: packet (event-driven 2), stamped_packet (the same with VLIB_ENABLE_TS), "
           "vbottle "
           "(event-driven 1)");
  v.choice("codec", config.codec, address_codec_names(), "layout of the bits of an event's address");
  v.integer("stamp_bits", config.stamp_bits, {24, 32}, "number of bits of a time stamp, which then wraps");
  v.integer("width_px", config.width_px, {1, 2048}, "image width, after swap_xy");
  v.integer("height_px", config.height_px, {1, 2048}, "image height, after swap_xy");
  v.boolean("swap_xy", config.swap_xy, "whether x and y are exchanged (DVS of 2016: swap_xy and flip_y)");
  v.boolean("flip_x", config.flip_x, "whether x is mirrored, after swap_xy");
  v.boolean("flip_y", config.flip_y, "whether y is mirrored, after swap_xy");
  v.boolean("swap_polarity", config.swap_polarity,
            "whether the polarity bit 1 means brighter, as event-driven's bridges to Prophesee cameras send "
            "it; else it "
            "means darker, as from event-driven's own cameras");
  v.integer("queue_events", config.queue_events, {1000, 1e7},
            "length of the queue of an eye; the oldest events beyond it are dropped");
  const auto codec = address_codec(config.codec);
  ImageSize sent{static_cast<int>(config.width_px), static_cast<int>(config.height_px)};
  if (config.swap_xy) std::swap(sent.width, sent.height);
  v.require(!codec || is_encodable(sent, *codec), "codec", config.codec,
            "a codec with room for the image's pixels");
}

void describe_head(FieldVisitor& v, YarpHeadConfig& config) {
  v.choice("control", config.control, {"joints", "gaze", "none"},
           "joints: references to the control board; gaze: targets to gaze_server; none: the camera alone");
  port_name(v, "part", config.part, false, "control board of neck and eyes");
  port_name(v, "torso_part", config.torso_part, true,
            "control board of the torso, only read; empty: the torso is upright");
  v.choice("carrier", config.carrier, carriers, "YARP carrier of readings and references");
}

void describe_gaze(FieldVisitor& v, YarpGazeConfig& config) {
  port_name(v, "name", config.name, false, "prefix of the gaze controller's ports");
  v.real("target_interval_ms", config.target_interval_ms, {0.0, 1000.0}, "shortest time between two targets");
  v.real("neck_time_s", config.neck_time_s, {0.2, 10.0}, "duration of a movement of the neck (Tneck)");
  v.real("eyes_time_s", config.eyes_time_s, {0.1, 10.0}, "duration of a movement of the eyes (Teyes)");
  v.boolean("tracking", config.tracking,
            "whether the gaze returns to the target after other programs moved the head (track)");
  v.boolean("saccades", config.saccades, "whether the eyes make saccades to distant targets (sacc)");
  v.boolean("bind_roll", config.bind_roll, "whether the roll of the neck is kept at 0");
}

}  // namespace

void describe(FieldVisitor& v, YarpConfig& config) {
  port_name(v, "local", config.local, false, "prefix of the ports of this program");
  v.real("timeout_s", config.timeout_s, {0.1, 60.0}, "longest wait for an answer during start and checks");
  v.section(
      "camera", [&](FieldVisitor& s) { describe_camera(s, config.camera); }, "the event camera");
  v.section(
      "head", [&](FieldVisitor& s) { describe_head(s, config.head); }, "control of the head");
  v.section(
      "gaze_server", [&](FieldVisitor& s) { describe_gaze(s, config.gaze_server); },
      "the robot's gaze controller (iKinGazeCtrl), with head.control: gaze");
  v.section(
      "imu",
      [&](FieldVisitor& s) {
        port_name(s, "port", config.imu.port, true,
                  "port of the head's inertial sensor (`/icub/inertial`: 12 numbers); empty: none");
        s.choice("carrier", config.imu.carrier, carriers, "YARP carrier of its readings");
      },
      "the inertial sensor in the head");
}

std::string head_name(const YarpConfig& config) {
  if (config.head.control == "none") return {};
  return config.head.control == "gaze" ? config.gaze_server.name : config.head.part;
}

EventTimelineConfig timeline_config(const YarpCameraConfig& config) {
  EventTimelineConfig timeline;
  timeline.image_size = {static_cast<int>(config.width_px), static_cast<int>(config.height_px)};
  timeline.codec = value_of<AddressCodec>(address_codec_names(), config.codec);
  timeline.format = value_of<PacketFormat>(packet_format_names(), config.format);
  timeline.stamp_bits = static_cast<int>(config.stamp_bits);
  timeline.swap_xy = config.swap_xy;
  timeline.flip_x = config.flip_x;
  timeline.flip_y = config.flip_y;
  timeline.swap_polarity = config.swap_polarity;
  return timeline;
}

}  // namespace saccade
