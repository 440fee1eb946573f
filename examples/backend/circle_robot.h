#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/config.h"
#include "robot/backend_registry.h"

namespace example {

/// The outline of a disc that moves along a circle in the image. The keys of this struct are in describe().
struct CircleRobotConfig {
  double radius_px = 14.0;          ///< of the disc
  double turns_per_s = 0.5;         ///< of the disc around the centre of the image
  std::int64_t events_per_ms = 20;  ///< on its outline
};

void describe(saccade::FieldVisitor& v, CircleRobotConfig& config);

/// A robot without hardware. Time passes when the loop waits for it; the head reaches each reference at once and does not
/// move the image.
class CircleRobot final : public saccade::Robot,
                          public saccade::Clock,
                          public saccade::EventSource,
                          public saccade::HeadPort {
 public:
  /// Throws InputError for a configuration out of range.
  CircleRobot(const CircleRobotConfig& config, const saccade::RobotContext& context);

  saccade::Clock& clock() override { return *this; }
  saccade::EventSource& events() override { return *this; }
  saccade::HeadPort* head() override { return this; }

  std::int64_t now_us() const override { return now_us_; }
  saccade::PortStatus wait_until(std::int64_t t_us) override;

  saccade::ImageSize image_size() const override { return size_; }
  saccade::PortStatus read_until(std::int64_t t_us, std::vector<saccade::Event>& events) override;
  std::int64_t heard_us() const override { return now_us_; }
  saccade::EventTraffic traffic() const override { return {}; }

  saccade::JointLimits limits() const override { return limits_; }
  saccade::PortStatus read(saccade::HeadState& state) override;
  CommandResult command(const saccade::HeadCommand& reference_rad) override;
  saccade::PortStatus stop() override { return saccade::PortStatus::ok; }

 private:
  [[nodiscard]] saccade::Event event_at(std::int64_t number) const;

  CircleRobotConfig config_;
  saccade::ImageSize size_;
  saccade::JointLimits limits_;
  std::int64_t now_us_ = 0;
  std::int64_t next_event_ = 0;
  saccade::JointVector position_rad_ = saccade::JointVector::Zero();
};

}  // namespace example
