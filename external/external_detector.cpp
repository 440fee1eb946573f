#include "external/external_detector.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "core/error.h"
#include "external/line_text.h"

namespace saccade {
namespace {

constexpr std::size_t record_bytes = 16;
constexpr std::string_view ready_form = "`ready THRESHOLD`, then `binary` and `motion` as wanted";
constexpr std::string_view estimate_form =
    "`none` or `circle X Y R SCORE`, then `held` and `covariance` with six numbers as needed";

void append_record(std::string& text, const Event& event) {
  std::array<char, record_bytes> record{};
  std::memcpy(record.data(), &event.t_us, 8);
  std::memcpy(record.data() + 8, &event.x, 2);
  std::memcpy(record.data() + 10, &event.y, 2);
  record[12] = event.on ? 1 : 0;
  record[13] = static_cast<char>(event.camera);
  text.append(record.data(), record.size());
}

void append_line(std::string& text, const Event& event) {
  append(text, event.t_us);
  append_word(text, event.x);
  append_word(text, event.y);
  text += event.on ? " 1\n" : " 0\n";
}

/// Six numbers xx, xy, xr, yy, yr, rr. None where they are no covariance.
std::optional<Eigen::Matrix3d> next_covariance(std::string_view& line) {
  std::array<double, 6> values{};
  for (double& value : values) {
    const auto number = next_number(line);
    if (!number) return std::nullopt;
    value = *number;
  }
  const auto [xx, xy, xr, yy, yr, rr] = values;
  if (xx < 0.0 || yy < 0.0 || rr < 0.0) return std::nullopt;
  Eigen::Matrix3d covariance;
  covariance << xx, xy, xr, xy, yy, yr, xr, yr, rr;
  return covariance;
}

}  // namespace

std::optional<ReadyLine> parse_ready(std::string_view line) {
  if (next_word(line) != "ready") return std::nullopt;
  const auto threshold = next_number(line);
  if (!threshold) return std::nullopt;
  ReadyLine ready{*threshold};
  for (std::string_view word = next_word(line); !word.empty(); word = next_word(line)) {
    if (word == "binary") {
      ready.binary = true;
    } else if (word == "motion") {
      ready.motion = true;
    } else {
      return std::nullopt;
    }
  }
  return ready;
}

std::optional<Estimate> parse_estimate(std::string_view line) {
  const std::string_view kind = next_word(line);
  if (kind == "none") return next_word(line).empty() ? std::optional(Estimate{}) : std::nullopt;
  if (kind != "circle") return std::nullopt;
  const auto x_px = next_number(line);
  const auto y_px = next_number(line);
  const auto r_px = next_number(line);
  const auto score = next_number(line);
  if (!x_px || !y_px || !r_px || !score || !(*r_px > 0.0)) return std::nullopt;
  Estimate estimate;
  estimate.valid = true;
  estimate.circle = {*x_px, *y_px, *r_px};
  estimate.score = *score;
  std::string_view word = next_word(line);
  if (word == "held") {
    estimate.held = true;
    word = next_word(line);
  }
  if (word == "covariance") {
    const auto covariance = next_covariance(line);
    if (!covariance) return std::nullopt;
    estimate.covariance_px2 = *covariance;
    word = next_word(line);
  }
  return word.empty() ? std::optional(estimate) : std::nullopt;
}

ExternalDetector::ExternalDetector(std::string name, const LineProcess::Place& place,
                                   const AnswerLimits& limits, const Camera& camera)
    : name_(std::move(name)),
      process_(place, milliseconds(limits.start_limit_s)),
      sieve_(camera.size),
      answer_limit_(milliseconds(limits.answer_limit_s)) {
  constexpr std::size_t expected_events = 1 << 12;
  events_.reserve(expected_events);
  message_.reserve(expected_events * record_bytes);
  start(limits, camera);
}

void ExternalDetector::start(const AnswerLimits& limits, const Camera& camera) {
  if (camera.lens == LensModel::fisheye || camera.k3 != 0.0) {
    throw InputError("camera",
                     "the lens " + std::string(word_of(camera.lens)) + (camera.k3 != 0.0 ? " with k3" : ""),
                     "radial_tangential without k3, which detectors in programs of their own are given");
  }
  message_ = "saccade-detector 1\ncamera";
  append_word(message_, camera.size.width);
  append_word(message_, camera.size.height);
  for (const double value :
       {camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px, camera.k1, camera.k2, camera.p1, camera.p2})
    append_word(message_, value);
  message_ += '\n';
  const auto limit = milliseconds(limits.start_limit_s);
  const LineProcess::Status status = process_.exchange(message_, limit, answer_);
  if (status != LineProcess::Status::ok) {
    fail(status, "at its start", limit);
    throw RunError("detector " + failure_);
  }
  if (const auto failure = stated_failure(process_, answer_, name_, "at its start"))
    throw RunError("detector " + *failure);
  const auto ready = parse_ready(answer_);
  if (!ready)
    throw RunError("detector " + name_ + " answered " + shown(answer_) + " at its start, expected " +
                   std::string(ready_form));
  threshold_ = ready->threshold;
  binary_ = ready->binary;
  wants_motion_ = ready->motion;
}

void ExternalDetector::process(std::span<const Event> events, const CameraMotion* motion) {
  if (!failure_.empty()) return;
  for (const Event& event : events) {
    if (!sieve_.accept(event)) continue;
    events_.push_back(event);
    now_us_ = event.t_us;
    changed_ = true;
  }
  motion_ = motion != nullptr ? std::optional(*motion) : std::nullopt;
}

void ExternalDetector::advance_to(std::int64_t now_us, const CameraMotion* motion) {
  now_us_ = std::max(now_us_, now_us);
  motion_ = motion != nullptr ? std::optional(*motion) : std::nullopt;
  changed_ = true;
}

void ExternalDetector::write_motion() {
  message_ += "motion";
  if (motion_) {
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column)
        append_word(message_, motion_->root_from_camera(row, column));
    }
    for (const double value : motion_->linear_velocity_m_s) append_word(message_, value);
    for (const double value : motion_->angular_velocity_rad_s) append_word(message_, value);
  } else {
    message_ += " none";
  }
  message_ += '\n';
}

void ExternalDetector::write_tick() {
  message_ = "tick";
  append_word(message_, now_us_);
  append_word(message_, events_.size());
  message_ += '\n';
  if (wants_motion_) write_motion();
  for (const Event& event : events_) binary_ ? append_record(message_, event) : append_line(message_, event);
}

Estimate ExternalDetector::estimate() {
  if (!failure_.empty()) return {};
  if (!changed_) return estimate_;
  changed_ = false;
  write_tick();
  events_.clear();
  const LineProcess::Status status = process_.exchange(message_, answer_limit_, answer_);
  const std::string moment = moment_of(now_us_);
  if (status != LineProcess::Status::ok) {
    fail(status, moment, answer_limit_);
    return estimate_ = {};
  }
  if (const auto failure = stated_failure(process_, answer_, name_, moment)) {
    failure_ = *failure;
    return estimate_ = {};
  }
  const auto estimate = parse_estimate(answer_);
  if (!estimate) {
    process_.end(std::chrono::milliseconds(0));
    failure_ =
        name_ + " answered " + shown(answer_) + " " + moment + ", expected " + std::string(estimate_form);
  }
  return estimate_ = estimate.value_or(Estimate{});
}

void ExternalDetector::fail(LineProcess::Status status, const std::string& moment,
                            std::chrono::milliseconds limit) {
  failure_ = end_program(process_, status, name_, moment, limit);
}

}  // namespace saccade
