#include "session/frame_camera.h"

#include <chrono>
#include <cmath>
#include <opencv2/core.hpp>

namespace saccade {

FrameCamera::FrameCamera(const FrameDetectorConfig& config, const SimConfig& sim,
                         const LatencyConfig& latency, SimRobot& robot)
    : detector_(config, sim.world.ball.rgb, sim.camera),
      shutter_(detector_.camera().size, config.exposure_ms),
      robot_(robot),
      latency_(latency) {}

void FrameCamera::on_tick(const Tick& tick) {
  const auto begin = std::chrono::steady_clock::now();
  const auto draw = [this](std::int64_t at_us, const Eigen::Vector2d& shift_px, std::span<float> rgb) {
    robot_.draw_left_eye(at_us, detector_.camera(), shift_px, rgb);
  };
  detection_.reset();
  const std::optional<cv::Mat> image = shutter_.expose(tick.t_us, draw);
  ready_us_.reset();
  if (image) {
    const auto find_begin = std::chrono::steady_clock::now();
    const Estimate ball = detector_.find(*image);
    find_ns_ = std::chrono::nanoseconds(std::chrono::steady_clock::now() - find_begin).count();
    if (ball.valid) detection_ = ball;
    ready_us_ = process(tick.t_us);
  }
  wall_s_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

std::optional<std::int64_t> FrameCamera::process(std::int64_t t_us) {
  if (latency_.kind == LatencyKind::none) return t_us;
  const std::int64_t arrived_us = t_us + latency_.transport_us();
  if (arrived_us < free_us_) return std::nullopt;
  const double work_us = latency_.kind == LatencyKind::measured
                             ? static_cast<double>(find_ns_) * 1e-3
                             : latency_.work_of(frame_detector_name).per_call_us;
  free_us_ = arrived_us + std::llround(std::ceil(work_us));
  return free_us_;
}

}  // namespace saccade
