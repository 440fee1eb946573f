#include "apps/session/frame_camera.h"

#include <chrono>
#include <opencv2/core.hpp>

namespace saccade {

FrameCamera::FrameCamera(const FrameDetectorConfig& config, const SimConfig& sim, SimRobot& robot)
    : detector_(config, sim.world.ball.rgb, sim.camera),
      shutter_(detector_.camera().size, config.exposure_ms),
      robot_(robot) {}

void FrameCamera::on_tick(const Tick& tick) {
  const auto begin = std::chrono::steady_clock::now();
  const auto draw = [this](std::int64_t at_us, const Eigen::Vector2d& shift_px, std::span<float> rgb) {
    robot_.draw_left_eye(at_us, detector_.camera(), shift_px, rgb);
  };
  detection_.reset();
  const std::optional<cv::Mat> image = shutter_.expose(tick.t_us, draw);
  exposed_ = image.has_value();
  if (image) {
    const Estimate ball = detector_.find(*image);
    if (ball.valid) detection_ = ball;
  }
  wall_s_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

}  // namespace saccade
