#include "apps/serve/gaze_server.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "control/neck_solver.h"
#include "control/target.h"
#include "core/error.h"
#include "core/units.h"

namespace saccade {
namespace {

constexpr std::size_t most_contexts = 100;             // the oldest ones beyond are forgotten
constexpr double bound_slack_rad = 0.1 / deg_per_rad;  // around a joint that is bound to one value
constexpr double still_rad_s = 0.5 / deg_per_rad;
constexpr double saccade_rad_s = 60.0 / deg_per_rad;
constexpr double still_for_s = 0.1;  // until a movement counts as done
constexpr std::int64_t oldest_imu_us = 40'000;
constexpr double imu_dead_band_rad_s = 5.0 / deg_per_rad;
/// Text in quotes: iKinGazeCtrl's client ends if it is another one, or a number.
constexpr std::string_view server_version = "\"2.0\"";
constexpr double largest_gain = 10.0;  // of vor and ocr
constexpr std::string_view ack = "[ack]";
constexpr std::string_view nack = "[nack]";

/// A reply with numbers; none that overflowed is sent.
std::string acknowledged(std::span<const double> values) {
  if (!std::ranges::all_of(values, [](double value) { return std::isfinite(value); }))
    return std::string(nack);
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

/// The version of an iCub head as text; nothing for another head.
std::string head_version(const HeadModel& head) {
  if (!head.is_icub) return {};
  const std::string number = head.name.substr(head.name.rfind(' ') + 1);
  return fmt::format("(head_version \"{}{}\") ", number, number.find('.') == std::string::npos ? ".0" : "");
}

}  // namespace

GazeServer::GazeServer(const IkinGazeConfig& gaze, const MotionLimitsConfig& motion,
                       const JointLimits& limits, const Camera& left, const Camera& right,
                       const JointVector& position_rad, bool has_imu)
    : motion_(motion),
      limits_(limits),
      cameras_{left, right},
      settings_{
          gaze, limits, has_imu ? 1.0 : 0.0, has_imu ? 0.0 : 1.0, {{"track", 0}, {"ntol", 0}, {"stab", 0}}} {
  state_.position_rad = position_rad;
  contexts_.emplace_back(0, settings_);  // as iKinGazeCtrl numbers the settings of the start
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
  RequestWords words(request);
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
  if (what != "stop" && suspended_ != (what == "susp")) {
    suspended_ = what == "susp";
    events_.emplace_back(suspended_ ? "suspended" : "resumed");
  }
  return std::string(ack);
}

std::string GazeServer::look(RequestWords& words) {
  const std::string kind = words.next();
  const std::optional<Eigen::Vector3d> target_m = geometry().point(kind, words);
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

/// Events are sent to every reader of events:o; clients that register for them are acknowledged.
std::string GazeServer::registered(const std::string& what, RequestWords& words) {
  if (what == "list") return fmt::format("{} ({})", ack, fmt::join(registered_, " "));
  const std::string event = words.next();
  constexpr std::array<std::string_view, 7> known = {
      "motion-onset", "motion-done", "saccade-onset", "saccade-done", "suspended", "resumed", "*"};
  if (std::ranges::find(known, event) == known.end()) return std::string(nack);
  std::erase(registered_, event);
  if (what == "register") registered_.push_back(event);
  return std::string(ack);
}

std::string GazeServer::get(RequestWords& words) const {
  const std::string what = words.next();
  const JointVector& q = state_.position_rad;
  const HeadKinematics head(limits_.head->chain, q);
  if (what == "x") return acknowledged(geometry().fixation_m());
  if (what == "q") return acknowledged(Eigen::VectorXd(q.head<joint_count>() * deg_per_rad));
  if (what == "angles" || what == "ang") {
    if (!words.has_more()) return acknowledged(geometry().angles_deg());
    const auto point_m = words.numbers(3);
    return point_m ? acknowledged(geometry().angles_deg(*point_m)) : std::string(nack);
  }
  if (what == "done") return acknowledged(done_ ? 1.0 : 0.0);
  if (what == "sdon") return acknowledged(saccade_done_ ? 1.0 : 0.0);
  if (what == "des")
    return acknowledged(Eigen::VectorXd(desired_rad_.segment<head_joint_count>(torso_slots) * deg_per_rad));
  if (what == "vel")
    return acknowledged(
        Eigen::VectorXd(state_.velocity_rad_s.segment<head_joint_count>(torso_slots) * deg_per_rad));
  if (what == "pid") return fmt::format("{} ()", ack);
  if (what == "tweak") return fmt::format("{} ({})", ack, pinholes_text(cameras_));
  if (what == "info") {
    return fmt::format(
        "{} ((server_version {}) {}(min_allowed_vergence {}) (events (motion-onset motion-done saccade-onset "
        "saccade-done suspended resumed)) {})",
        ack, server_version, head_version(*limits_.head), least_vergence_deg, pinholes_text(cameras_));
  }
  if (what == "3D") {
    const std::string kind = words.next();
    const auto found = kind == "3D"     ? std::nullopt
                       : kind == "proj" ? geometry().on_plane(words)
                                        : geometry().point(kind, words);
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

std::string GazeServer::set(RequestWords& words) {
  const std::string what = words.next();
  if (what == "tweak") {
    if (!read_pinholes(words, cameras_)) return std::string(nack);
    ++requests_;
    return std::string(ack);
  }
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
    if (std::abs(value) > largest_gain) return std::string(nack);
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

std::string GazeServer::bind(RequestWords& words) {
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

std::string GazeServer::clear(RequestWords& words) {
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

std::string GazeServer::contexts(const std::string& what, RequestWords& words) {
  if (what == "stor") {
    if (contexts_.size() == most_contexts) contexts_.erase(contexts_.begin() + 1);
    contexts_.emplace_back(next_context_, settings_);
    return acknowledged(static_cast<double>(next_context_++));
  }
  if (what == "del") {  // unknown ones too, as in iKinGazeCtrl; that of the start stays
    std::vector<double> ids;
    while (words.has_more()) {
      const auto id = words.next_numbers(1);
      if (!id) return std::string(nack);
      ids.push_back((*id)[0]);
    }
    std::erase_if(contexts_, [&](const auto& stored) {
      return stored.first != 0 && std::ranges::find(ids, static_cast<double>(stored.first)) != ids.end();
    });
    return std::string(ack);
  }
  const auto id = words.numbers(1);
  if (!id) return std::string(nack);
  const auto context = std::ranges::find_if(
      contexts_, [&](const auto& stored) { return static_cast<double>(stored.first) == (*id)[0]; });
  return context == contexts_.end() ? std::string(nack) : adopt(context->second);
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
  if (saccade_done_ != (eye_rad_s < saccade_rad_s)) {
    saccade_done_ = !saccade_done_;
    events_.emplace_back(saccade_done_ ? "saccade-done" : "saccade-onset");
  }
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
  report.fixation_m = geometry().fixation_m();
  report.position_rad = state_.position_rad;
  report.angles_deg = geometry().angles_deg();
  report.target_m = target_m_;
  report.events = std::exchange(events_, {});
  report.requests = requests_;
  return report;
}

}  // namespace saccade
