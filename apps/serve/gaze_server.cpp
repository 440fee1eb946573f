#include "apps/serve/gaze_server.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numbers>
#include <utility>

#include "control/neck_solver.h"
#include "control/target.h"
#include "core/error.h"
#include "core/units.h"

namespace saccade::inline v0_1 {
namespace {

constexpr double least_vergence_deg = 0.5;
constexpr std::size_t most_contexts = 100;             // the oldest ones beyond are forgotten
constexpr double bound_slack_rad = 0.1 / deg_per_rad;  // around a joint that is bound to one value
constexpr double still_rad_s = 0.5 / deg_per_rad;
constexpr double saccade_rad_s = 60.0 / deg_per_rad;
constexpr double still_for_s = 0.1;  // until a movement counts as done
constexpr std::int64_t oldest_imu_us = 40'000;
constexpr double imu_dead_band_rad_s = 5.0 / deg_per_rad;
/// Text in quotes: iKinGazeCtrl's client ends if it is another one, or a number.
constexpr std::string_view server_version = "\"2.0\"";
constexpr std::string_view ack = "[ack]";
constexpr std::string_view nack = "[nack]";

std::string acknowledged(std::span<const double> values) {
  std::string text = "[ack] (";
  for (const double value : values) text += fmt::format("{}{:.9g}", text.ends_with('(') ? "" : " ", value);
  return text + ")";
}

std::string acknowledged(const Eigen::VectorXd& values) {
  return acknowledged(std::span(values.data(), static_cast<std::size_t>(values.size())));
}

std::string acknowledged(double value) { return fmt::format("[ack] {:.9g}", value); }

std::optional<Joint> neck_joint(const std::string& name) {
  if (name == "pitch") return neck_pitch;
  if (name == "roll") return neck_roll;
  if (name == "yaw") return neck_yaw;
  return std::nullopt;
}

/// The requested range of a joint, clipped to the limits of the hardware; at least a small range around its middle.
void bind_joint(JointLimits& limits, const JointLimits& hardware, Joint joint, double min_rad,
                double max_rad) {
  double min = std::clamp(min_rad, hardware.min_rad[joint], hardware.max_rad[joint]);
  double max = std::clamp(max_rad, hardware.min_rad[joint], hardware.max_rad[joint]);
  if (max - min < 2 * bound_slack_rad) {
    const double middle = std::clamp((min + max) / 2, hardware.min_rad[joint] + bound_slack_rad,
                                     hardware.max_rad[joint] - bound_slack_rad);
    min = middle - bound_slack_rad;
    max = middle + bound_slack_rad;
  }
  limits.min_rad[joint] = min;
  limits.max_rad[joint] = max;
}

/// The point on the ray through a pixel of a pinhole camera at a depth; eye frame.
Eigen::Vector3d through_pixel(const Camera& camera, double u_px, double v_px, double z_m) {
  return z_m *
         Eigen::Vector3d((u_px - camera.cx_px) / camera.fx_px, (v_px - camera.cy_px) / camera.fy_px, 1.0);
}

/// The version of an iCub head as text; nothing for another head.
std::string head_version(const HeadModel& head) {
  if (!head.is_icub) return {};
  const std::string number = head.name.substr(head.name.rfind(' ') + 1);
  return fmt::format("(head_version \"{}{}\") ", number, number.find('.') == std::string::npos ? ".0" : "");
}

}  // namespace

/// Reads a request word by word.
class GazeServer::Words {
 public:
  explicit Words(const std::string& text) {
    std::string word;
    for (const char c : text + " ") {
      if (std::string_view(" \t\r\n()[]\",").find(c) == std::string_view::npos) {
        word += c;
      } else if (!word.empty()) {
        words_.push_back(std::move(word));
        word.clear();
      }
    }
  }
  std::string next() { return at_ < words_.size() ? words_[at_++] : std::string(); }
  /// Whether `word` is there after `after` others; takes it out.
  bool take(std::string_view word, std::size_t after) {
    if (at_ + after >= words_.size() || words_[at_ + after] != word) return false;
    words_.erase(words_.begin() + static_cast<std::ptrdiff_t>(at_ + after));
    return true;
  }
  [[nodiscard]] bool has_more() const { return at_ < words_.size(); }
  /// The remaining words as numbers; none unless they are exactly that many finite numbers.
  std::optional<Eigen::VectorXd> numbers(int count) {
    const auto values = next_numbers(count);
    return has_more() ? std::nullopt : values;
  }
  std::optional<Eigen::VectorXd> next_numbers(int count) {
    Eigen::VectorXd values(count);
    for (int i = 0; i < count; ++i) {
      const std::string word = next();
      const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), values[i]);
      if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(values[i])) return {};
    }
    return values;
  }

 private:
  std::vector<std::string> words_;
  std::size_t at_ = 0;
};

GazeServer::GazeServer(const IkinGazeConfig& gaze, const MotionLimitsConfig& motion,
                       const JointLimits& limits, const Camera& left, const Camera& right,
                       const JointVector& position_rad, bool has_imu)
    : motion_(motion),
      limits_(limits),
      cameras_{left, right},
      settings_{
          gaze, limits, has_imu ? 1.0 : 0.0, has_imu ? 0.0 : 1.0, {{"track", 0}, {"ntol", 0}, {"stab", 0}}} {
  state_.position_rad = position_rad;
  restart();
}

void GazeServer::restart() {
  controller_ =
      std::make_unique<IkinGazeController>(settings_.gaze, motion_limits(settings_.limits, motion_));
  controller_->set_counter_gains(settings_.vor, settings_.ocr);
  limiter_ = std::make_unique<JointLimiter>(motion_limits(limits_, motion_));
  target_is_new_ = target_m_.has_value();
}

std::string GazeServer::answer(const std::string& request) {
  const std::scoped_lock lock(mutex_);
  Words words(request);
  const std::string what = words.next();
  if (what == "look") return look(words);
  if (what == "get") return get(words);
  if (what == "set") return set(words);
  if (what == "bind") return bind(words);
  if (what == "clear") return clear(words);
  if (what == "stor" || what == "rest" || what == "del") return contexts(what, words);
  if (what == "register" || what == "unregister" || what == "list") return registered(what, words);
  if (what == "status") return fmt::format("{} {}", ack, suspended_ ? "suspended" : "running");
  if (what == "help") {
    return fmt::format(
        "{} (\"look 3D|mono|stereo|ang (...)\" \"get "
        "x|q|angles|ang|done|sdon|des|vel|pid|tweak|info|3D|2D|pose|Tneck|Teyes|sacc|sact|sinh|pitch|"
        "roll|yaw\" \"set Tneck|Teyes|sacc|sact|sinh|track|ntol|vor|ocr|stab VALUE\" \"bind pitch|roll|yaw "
        "MIN MAX\" "
        "\"bind eyes VERGENCE\" \"clear pitch|roll|yaw|eyes\" \"stop\" \"susp\" \"run\" \"status\" \"stor\" "
        "\"rest ID\" "
        "\"del ID\" \"register EVENT\" \"unregister EVENT\" \"list\")",
        ack);
  }
  if (what != "stop" && what != "susp" && what != "run") return std::string(nack);
  ++requests_;
  if (what != "run") {
    stop_ = stop_ || target_m_.has_value();
    target_m_.reset();
  }
  if (what != "stop") suspended_ = what == "susp";
  return std::string(ack);
}

std::string GazeServer::look(Words& words) {
  const std::string kind = words.next();
  const std::optional<Eigen::Vector3d> target_m = point(kind, words);
  if (!target_m || suspended_ ||
      check_gaze_target(*target_m, HeadKinematics(limits_.head->chain, state_.position_rad)) !=
          TargetStatus::ok) {
    return std::string(nack);
  }
  ++requests_;
  if (!target_m_) restart();
  target_m_ = target_m;
  target_is_new_ = true;
  stop_ = false;
  return std::string(ack);
}

std::optional<Eigen::Vector3d> GazeServer::point(const std::string& kind, Words& words) const {
  const JointVector& q = state_.position_rad;
  const HeadKinematics head(limits_.head->chain, q);
  if (kind == "3D") {
    const auto values = words.numbers(3);
    if (values) return Eigen::Vector3d(*values);
  } else if (kind == "mono") {
    const std::string eye = words.next();
    const bool by_vergence = words.take("ver", 2);
    const auto values = words.numbers(3);
    if (!values || (eye != "left" && eye != "right") || (*values)[2] <= 0.0) return {};
    const Eye which = eye == "left" ? Eye::left : Eye::right;
    Eigen::Vector3d seen =
        through_pixel(cameras_[static_cast<std::size_t>(which)], (*values)[0], (*values)[1], 1.0);
    if (by_vergence) {
      const double half_rad = std::max((*values)[2], least_vergence_deg) / deg_per_rad / 2;
      seen *= CyclopeanEye(limits_.head->chain, q).half_baseline_m() / std::tan(half_rad) / seen.norm();
    } else {
      seen *= (*values)[2];
    }
    return head.root_from_eye(which) * seen;
  } else if (kind == "stereo") {
    const auto values = words.numbers(4);
    if (!values) return {};
    const auto ray = [&](Eye eye, double u_px, double v_px) {
      const Eigen::Isometry3d& pose = head.root_from_eye(eye);
      return Ray{pose.translation(),
                 pose.linear() * through_pixel(cameras_[static_cast<std::size_t>(eye)], u_px, v_px, 1.0)};
    };
    return triangulate(ray(Eye::left, (*values)[0], (*values)[1]),
                       ray(Eye::right, (*values)[2], (*values)[3]), least_vergence_deg / deg_per_rad,
                       std::numbers::pi / 2);
  } else if (kind == "ang") {
    const std::string mode = words.next();
    const auto values = words.numbers(3);
    if (!values || (mode != "abs" && mode != "rel")) return {};
    const Eigen::Vector3d angles =
        (mode == "rel" ? angles_deg() : Eigen::Vector3d(Eigen::Vector3d::Zero())) + Eigen::Vector3d(*values);
    const double azimuth = angles[0] / deg_per_rad;
    const double elevation = angles[1] / deg_per_rad;
    const double vergence = std::max(angles[2], least_vergence_deg) / deg_per_rad;
    JointVector upright = q;
    upright.tail<gaze_slots>().setZero();
    const CyclopeanEye eye(limits_.head->chain, upright);
    const Eigen::Vector3d direction(std::sin(azimuth) * std::cos(elevation), -std::sin(elevation),
                                    std::cos(azimuth) * std::cos(elevation));
    return eye.root_from_eye() * Eigen::Vector3d(eye.half_baseline_m() / std::tan(vergence / 2) * direction);
  }
  return {};
}

/// Where the ray through a pixel of an eye meets the plane a x + b y + c z + d = 0: eye u v a b c d.
std::optional<Eigen::Vector3d> GazeServer::on_plane(Words& words) const {
  const std::string eye = words.next();
  const auto values = words.numbers(6);
  if (!values || (eye != "left" && eye != "right")) return {};
  const Eye which = eye == "left" ? Eye::left : Eye::right;
  const Eigen::Isometry3d pose =
      HeadKinematics(limits_.head->chain, state_.position_rad).root_from_eye(which);
  const Eigen::Vector3d ray = pose.linear() * through_pixel(cameras_[static_cast<std::size_t>(which)],
                                                            (*values)[0], (*values)[1], 1.0);
  const Eigen::Vector3d normal = values->segment<3>(2);
  const double towards = normal.dot(ray);
  const double depth_m = -(normal.dot(pose.translation()) + (*values)[5]) / towards;
  if (!std::isfinite(depth_m) || depth_m <= 0.0) return {};
  return pose.translation() + depth_m * ray;
}

/// The fixation point; while the optical axes are parallel, where they would meet with the least vergence.
Eigen::Vector3d GazeServer::fixation_m() const {
  const FixationPoint fixation = HeadKinematics(limits_.head->chain, state_.position_rad).fixation();
  if (fixation.valid) return fixation.point_m;
  const CyclopeanEye eye(limits_.head->chain, state_.position_rad);
  const double distance_m = eye.half_baseline_m() / std::tan(least_vergence_deg / deg_per_rad / 2);
  return eye.root_from_eye() * Eigen::Vector3d(0.0, 0.0, distance_m);
}

/// Events are sent to every reader of events:o; clients that register for them are acknowledged.
std::string GazeServer::registered(const std::string& what, Words& words) {
  if (what == "list") return fmt::format("{} ({})", ack, fmt::join(registered_, " "));
  const std::string event = words.next();
  constexpr std::array<std::string_view, 6> known = {"motion-onset", "motion-done", "saccade-onset",
                                                     "saccade-done", "closing",     "*"};
  if (std::ranges::find(known, event) == known.end()) return std::string(nack);
  std::erase(registered_, event);
  if (what == "register") registered_.push_back(event);
  return std::string(ack);
}

Eigen::Vector3d GazeServer::angles_deg() const {
  const JointVector& q = state_.position_rad;
  JointVector upright = q;
  upright.tail<gaze_slots>().setZero();
  const CyclopeanEye eye(limits_.head->chain, upright);
  const HeadKinematics head(limits_.head->chain, q);
  const FixationPoint fixation = head.fixation();
  // If the axes do not intersect: a distant point on the left axis.
  const Eigen::Vector3d seen =
      eye.see(fixation.valid ? fixation.point_m : head.root_from_eye(Eye::left) * Eigen::Vector3d(0, 0, 10));
  return Eigen::Vector3d(std::atan2(seen.x(), seen.z()),
                         -std::atan2(seen.y(), std::hypot(seen.x(), seen.z())), q[eyes_vergence]) *
         deg_per_rad;
}

/// The pinholes of both eyes, as iKinGazeCtrl reports them: projections (3 x 4, row by row) and image sizes.
std::string GazeServer::cameras_text() const {
  std::string text;
  for (const Eye eye : {Eye::left, Eye::right}) {
    const std::string_view name = eye == Eye::left ? "left" : "right";
    const Camera& camera = cameras_[static_cast<std::size_t>(eye)];
    text += fmt::format(
        "{}(camera_intrinsics_{} ({} 0.0 {} 0.0 0.0 {} {} 0.0 0.0 0.0 1.0 0.0)) (camera_width_{} {}) "
        "(camera_height_{} {})",
        text.empty() ? "" : " ", name, camera.fx_px, camera.cx_px, camera.fy_px, camera.cy_px, name,
        camera.size.width, name, camera.size.height);
  }
  return text;
}

std::string GazeServer::get(Words& words) const {
  const std::string what = words.next();
  const JointVector& q = state_.position_rad;
  const HeadKinematics head(limits_.head->chain, q);
  if (what == "x") return acknowledged(fixation_m());
  if (what == "q") return acknowledged(Eigen::VectorXd(q.head<joint_count>() * deg_per_rad));
  if (what == "angles" || what == "ang") return acknowledged(angles_deg());
  if (what == "done") return acknowledged(done_ ? 1.0 : 0.0);
  if (what == "sdon") return acknowledged(saccade_done_ ? 1.0 : 0.0);
  if (what == "des") return acknowledged(Eigen::VectorXd(desired_rad_.head<joint_count>() * deg_per_rad));
  if (what == "vel")
    return acknowledged(Eigen::VectorXd(state_.velocity_rad_s.head<joint_count>() * deg_per_rad));
  if (what == "pid") return fmt::format("{} ()", ack);
  if (what == "tweak") return fmt::format("{} ({})", ack, cameras_text());
  if (what == "info") {
    return fmt::format(
        "{} ((server_version {}) {}(min_allowed_vergence {}) (events (motion-onset motion-done)) {})", ack,
        server_version, head_version(*limits_.head), least_vergence_deg, cameras_text());
  }
  if (what == "3D") {
    const std::string kind = words.next();
    const auto found = kind == "3D" ? std::nullopt : kind == "proj" ? on_plane(words) : point(kind, words);
    return found ? acknowledged(*found) : std::string(nack);
  }
  if (what == "2D" || what == "pose") {
    const std::string name = words.next();
    const bool is_eye = name == "left" || name == "right";
    const Eye eye = name == "right" ? Eye::right : Eye::left;
    if (what == "2D") {
      const auto values = words.numbers(3);
      if (!values || !is_eye) return std::string(nack);
      const Eigen::Vector3d seen = head.root_from_eye(eye).inverse() * Eigen::Vector3d(*values);
      const Camera& camera = cameras_[static_cast<std::size_t>(eye)];
      if (seen.z() <= 0.0) return std::string(nack);
      return acknowledged(Eigen::Vector2d(camera.fx_px * seen.x() / seen.z() + camera.cx_px,
                                          camera.fy_px * seen.y() / seen.z() + camera.cy_px));
    }
    if (!is_eye && name != "head") return std::string(nack);
    const Eigen::Isometry3d pose =
        is_eye ? head.root_from_eye(eye) : CyclopeanEye(limits_.head->chain, q).root_from_eye();
    const Eigen::AngleAxisd turn(pose.linear());
    Eigen::VectorXd values(7);
    values << pose.translation(), turn.axis(), turn.angle();
    return acknowledged(values);
  }
  const auto range = [&](Joint joint) {
    const double min_deg = settings_.limits.min_rad[joint] * deg_per_rad;
    const double max_deg = settings_.limits.max_rad[joint] * deg_per_rad;
    const bool one_value = max_deg - min_deg < 2.01 * bound_slack_rad * deg_per_rad;
    const double middle_deg = (min_deg + max_deg) / 2;
    return one_value ? std::pair(middle_deg, middle_deg) : std::pair(min_deg, max_deg);
  };
  if (const auto joint = neck_joint(what)) {
    const auto [min_deg, max_deg] = range(*joint);
    return fmt::format("{} {:.9g} {:.9g}", ack, min_deg, max_deg);
  }
  if (what == "eyes") {
    const auto [min_deg, max_deg] = range(eyes_vergence);
    return min_deg == max_deg ? acknowledged(min_deg) : acknowledged(-1.0);
  }
  const IkinGazeConfig& gaze = settings_.gaze;
  if (what == "Tneck") return acknowledged(gaze.neck_time_s);
  if (what == "Teyes") return acknowledged(gaze.eyes_time_s);
  if (what == "sacc") return acknowledged(gaze.saccades ? 1.0 : 0.0);
  if (what == "sact") return acknowledged(gaze.saccade_angle_deg);
  if (what == "sinh") return acknowledged(gaze.saccade_interval_s);
  if (what == "vor") return acknowledged(settings_.vor);
  if (what == "ocr") return acknowledged(settings_.ocr);
  for (const auto& [name, value] : settings_.kept) {
    if (what == name) return acknowledged(value);
  }
  return std::string(nack);
}

/// Applies settings to the controller; keeps the previous ones if it rejects them.
std::string GazeServer::adopt(Settings settings) {
  std::swap(settings_, settings);
  try {
    restart();
  } catch (const InputError&) {
    settings_ = std::move(settings);
    restart();
    return std::string(nack);
  }
  ++requests_;
  return std::string(ack);
}

std::string GazeServer::set(Words& words) {
  const std::string what = words.next();
  if (what == "tweak") return set_cameras(words);
  if (what == "pid") return std::string(words.has_more() ? nack : ack);
  const auto values = words.numbers(1);
  if (!values) return std::string(nack);
  const double value = (*values)[0];
  Settings settings = settings_;
  IkinGazeConfig& gaze = settings.gaze;
  // As in iKinGazeCtrl: at least 0.1 s for the eyes, and 0.2 s more for the neck.
  if (what == "Teyes") {
    gaze.eyes_time_s = std::max(value, 0.1);
    gaze.neck_time_s = std::max(gaze.neck_time_s, gaze.eyes_time_s + 0.2);
  } else if (what == "Tneck") {
    gaze.neck_time_s = std::max(value, gaze.eyes_time_s + 0.2);
  } else if (what == "sacc") {
    gaze.saccades = value != 0.0;
  } else if (what == "sact") {
    gaze.saccade_angle_deg = value;
  } else if (what == "sinh") {
    gaze.saccade_interval_s = value;
  } else if (what == "vor" || what == "ocr") {
    (what == "vor" ? settings_.vor : settings_.ocr) = value;
    controller_->set_counter_gains(settings_.vor, settings_.ocr);
    ++requests_;
    return std::string(ack);
  } else {
    const auto kept = std::ranges::find(settings.kept, what, &std::pair<std::string, double>::first);
    if (kept == settings.kept.end()) return std::string(nack);
    kept->second = value;
    settings_ = std::move(settings);
    ++requests_;
    return std::string(ack);
  }
  return adopt(std::move(settings));
}

/// The intrinsics of an eye, which `get tweak` reports; the image sizes stay.
std::string GazeServer::set_cameras(Words& words) {
  std::array<Camera, 2> cameras = {cameras_[0], cameras_[1]};
  while (words.has_more()) {
    const std::string key = words.next();
    const auto eye = key.ends_with("_left")    ? std::optional(Eye::left)
                     : key.ends_with("_right") ? std::optional(Eye::right)
                                               : std::nullopt;
    if (!eye) return std::string(nack);
    Camera& camera = cameras[static_cast<std::size_t>(*eye)];
    const std::string what = key.substr(0, key.rfind('_'));
    const auto values = words.next_numbers(what == "camera_intrinsics" ? 12 : 1);
    if (!values) return std::string(nack);
    if (what == "camera_intrinsics") {
      if ((*values)[0] <= 0.0 || (*values)[5] <= 0.0) return std::string(nack);
      camera.fx_px = (*values)[0];
      camera.cx_px = (*values)[2];
      camera.fy_px = (*values)[5];
      camera.cy_px = (*values)[6];
    } else if ((what != "camera_width" || (*values)[0] != camera.size.width) &&
               (what != "camera_height" || (*values)[0] != camera.size.height)) {
      return std::string(nack);
    }
  }
  std::ranges::copy(cameras, cameras_);
  ++requests_;
  return std::string(ack);
}

std::string GazeServer::bind(Words& words) {
  const std::string what = words.next();
  Settings settings = settings_;
  if (what == "eyes") {
    const auto values = words.numbers(1);
    if (!values) return std::string(nack);
    bind_joint(settings.limits, limits_, eyes_tilt, 0.0, 0.0);
    bind_joint(settings.limits, limits_, eyes_version, 0.0, 0.0);
    const double vergence = (*values)[0] / deg_per_rad;
    bind_joint(settings.limits, limits_, eyes_vergence, vergence, vergence);
    return adopt(std::move(settings));
  }
  const auto joint = neck_joint(what);
  const auto values = words.numbers(2);
  if (!joint || !values || (*values)[0] > (*values)[1]) return std::string(nack);
  bind_joint(settings.limits, limits_, *joint, (*values)[0] / deg_per_rad, (*values)[1] / deg_per_rad);
  return adopt(std::move(settings));
}

std::string GazeServer::clear(Words& words) {
  const std::string what = words.next();
  Settings settings = settings_;
  const auto free = [&](Joint joint) {
    settings.limits.min_rad[joint] = limits_.min_rad[joint];
    settings.limits.max_rad[joint] = limits_.max_rad[joint];
  };
  if (const auto joint = neck_joint(what)) {
    free(*joint);
  } else if (what == "eyes") {
    for (const Joint eye : {eyes_tilt, eyes_version, eyes_vergence}) free(eye);
  } else {
    return std::string(nack);
  }
  return adopt(std::move(settings));
}

std::string GazeServer::contexts(const std::string& what, Words& words) {
  if (what == "stor") {
    if (contexts_.size() == most_contexts) contexts_.erase(contexts_.begin());
    contexts_.emplace_back(next_context_, settings_);
    return acknowledged(static_cast<double>(next_context_++));
  }
  const auto id = words.numbers(1);
  if (!id) return std::string(nack);
  const auto context = std::ranges::find_if(
      contexts_, [&](const auto& stored) { return static_cast<double>(stored.first) == (*id)[0]; });
  if (context == contexts_.end()) return std::string(nack);
  if (what == "rest") return adopt(context->second);
  contexts_.erase(context);
  return std::string(ack);
}

/// The rotation of the head that the gyroscope measures, root frame; 0 below the dead band and without a fresh reading.
Eigen::Vector3d GazeServer::head_rotation_rad_s(const ImuReading* imu) const {
  if (imu == nullptr || !imu->angular_velocity_rad_s.allFinite() || state_.t_us - imu->t_us > oldest_imu_us ||
      imu->angular_velocity_rad_s.norm() < imu_dead_band_rad_s)
    return Eigen::Vector3d::Zero();
  const auto root_from_eye = [&](const JointVector& q) -> Eigen::Matrix3d {
    return HeadKinematics(limits_.head->chain, q).root_from_eye(Eye::left).linear();
  };
  JointVector carried_rad = state_.position_rad;
  carried_rad.segment<3>(eyes_tilt).setZero();
  return root_from_eye(carried_rad) * root_from_eye(JointVector::Zero()).transpose() *
         imu->angular_velocity_rad_s;
}

std::optional<HeadJointVector> GazeServer::step(const HeadState& state, double dt_s, const ImuReading* imu) {
  const std::scoped_lock lock(mutex_);
  if (is_finite(state)) state_ = state;
  const auto become = [&](bool done) {
    if (done != done_) events_.emplace_back(done ? "motion-done" : "motion-onset");
    done_ = done;
  };
  const double eye_rad_s = state_.velocity_rad_s.segment<3>(eyes_tilt).cwiseAbs().maxCoeff();
  saccade_done_ = eye_rad_s < saccade_rad_s;
  if (!target_m_) {
    desired_rad_ = state_.position_rad;
    become(true);
    if (!stop_) return {};
    stop_ = false;
    return state_.head_position_rad()
        .cwiseMax(limits_.min_rad.tail<gaze_slots>())
        .cwiseMin(limits_.max_rad.tail<gaze_slots>());
  }
  if (target_is_new_) {
    still_s_ = 0.0;
    become(false);
  }
  const bool still = state_.velocity_rad_s.tail<gaze_slots>().cwiseAbs().maxCoeff() < still_rad_s;
  still_s_ = still ? still_s_ + dt_s : 0.0;
  if (still_s_ >= still_for_s) become(true);
  controller_->set_head_rotation(head_rotation_rad_s(imu));
  const HeadJointVector wanted = controller_->step(state, target_is_new_ ? target_m_ : std::nullopt, dt_s);
  target_is_new_ = false;
  desired_rad_ = state_.position_rad;
  desired_rad_.tail<gaze_slots>() = wanted;
  return limiter_->apply(wanted, state_.head_position_rad(), dt_s).reference_rad;
}

GazeServer::Report GazeServer::report() {
  const std::scoped_lock lock(mutex_);
  Report report;
  report.fixation_m = fixation_m();
  report.position_rad = state_.position_rad;
  report.angles_deg = angles_deg();
  report.target_m = target_m_;
  report.events = std::exchange(events_, {});
  report.requests = requests_;
  return report;
}

}  // namespace saccade::inline v0_1
