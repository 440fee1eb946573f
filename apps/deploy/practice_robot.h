#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "apps/deploy/shared_head.h"
#include "core/camera.h"
#include "core/config.h"
#include "head/icub_cameras.h"
#include "robot/backend_registry.h"
#include "robot/steady_clock.h"

namespace saccade {

/// The backend `practice`.
struct PracticeConfig {
  std::string head = "head";      ///< name of the head; programs with the same name share it
  double ball_distance_m = 0.45;  ///< from the root's origin to the middle of the ball's circle, forward
  double circle_radius_m = 0.04;  ///< of the ball's circle
  double circle_period_s = 4.0;   ///< of one turn
  double noise_hz = 0.1;          ///< noise events per pixel and second
  double end_s = 0.0;             ///< time after which its ports end; 0: never
};

/// Keys: head, ball_distance_m, circle_radius_m, circle_period_s, noise_hz, end_s.
void describe(FieldVisitor& v, PracticeConfig& config);
[[nodiscard]] std::string head_name(const PracticeConfig& config);

/// A robot to practise deploy and its guard with, without a simulator, a network or a recording: a head in shared memory
/// (SharedHead), and the camera of its left eye, which sees a bright ball of 95 mm that moves on a circle. In real time.
/// A pixel sends an event when the outline of the ball passes it; an image is drawn every millisecond, so events of a
/// millisecond have the same time stamp. The lens is that of the iCub (Camera), 128 x 128 pixels.
class PracticeRobot final : public Robot, public EventSource, public HeadPort {
 public:
  /// Throws InputError for a configuration out of range or another image size, RunError without shared memory.
  PracticeRobot(const PracticeConfig& config, const RobotContext& context);

  Clock& clock() override { return clock_; }
  EventSource& events() override { return *this; }
  HeadPort* head() override { return this; }
  std::vector<StartUpCheck> check() override;
  void activate() override;
  void release() override;
  void halt() override;

  [[nodiscard]] ImageSize image_size() const override { return camera_.size; }
  PortStatus read_until(std::int64_t t_us, std::vector<Event>& events) override;
  [[nodiscard]] std::int64_t heard_us() const override { return clock_.now_us(); }
  [[nodiscard]] EventTraffic traffic() const override { return {}; }

  [[nodiscard]] JointLimits limits() const override { return limits_; }
  PortStatus read(HeadState& state) override;
  [[nodiscard]] HeadDrives drives() const override;
  CommandResult command(const HeadCommand& reference_rad) override;
  PortStatus stop() override;

 private:
  /// A disc in the image; none where the ball is not in view.
  struct Disc {
    double x_px = 0.0, y_px = 0.0, r_px = 0.0;
    [[nodiscard]] bool covers(int x, int y) const;
  };
  class RealClock final : public Clock {
   public:
    explicit RealClock(double end_s) : end_us_(end_s > 0.0 ? static_cast<std::int64_t>(end_s * 1e6) : 0) {}
    [[nodiscard]] std::int64_t now_us() const override { return steady_.now_us(); }
    PortStatus wait_until(std::int64_t t_us) override;
    [[nodiscard]] bool is_over() const { return end_us_ > 0 && now_us() >= end_us_; }

   private:
    SteadyClock steady_;
    std::int64_t end_us_;
  };

  [[nodiscard]] Disc look(std::int64_t t_us) const;
  void draw(std::int64_t t_us, std::vector<Event>& events);

  PracticeConfig config_;
  JointLimits limits_;
  Camera camera_ = icub_left_2016;
  RealClock clock_;
  std::int64_t start_ns_;
  SharedHead head_;
  std::atomic<std::uint64_t> taken_ = 0;  // the number of the newest take(); 0: not active
  std::int64_t drawn_us_ = 0;
  Disc disc_;
};

/// The connection of the guard to a practice head.
class PracticeStopper final : public HeadStopper {
 public:
  explicit PracticeStopper(const PracticeConfig& config) : head_(config.head) {}
  [[nodiscard]] bool is_connected() override { return true; }
  bool stop() override;

 private:
  SharedHead head_;
};

}  // namespace saccade
