#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "robot/fake/fake_robot.h"
#include "tests/control/genova02.h"

namespace saccade {

/// The fake robot with a camera that sends its events in packets, every 5 ms those since the last packet.
class PacketRobot final : public Robot, private EventSource {
 public:
  static constexpr std::int64_t packet_us = 5'000;

  /// `events`: sorted by time.
  explicit PacketRobot(std::vector<Event> events) : fake_(script()), events_(std::move(events)) {}

  Clock& clock() override { return fake_; }
  EventSource& events() override { return *this; }
  HeadPort* head() override { return &fake_; }
  /// The time of the newest packet.
  [[nodiscard]] std::int64_t sent_us() const { return fake_.now_us() / packet_us * packet_us; }

 private:
  static FakeRobotScript script() {
    FakeRobotScript script;
    script.limits = genova02_limits();
    return script;
  }
  [[nodiscard]] ImageSize image_size() const override { return fake_.image_size(); }
  PortStatus read_until(std::int64_t t_us, std::vector<Event>& events) override {
    for (; next_ < events_.size() && events_[next_].t_us <= std::min(t_us, sent_us()); ++next_)
      events.push_back(events_[next_]);
    return PortStatus::ok;
  }
  [[nodiscard]] std::int64_t heard_us() const override { return fake_.heard_us(); }
  [[nodiscard]] EventTraffic traffic() const override { return {}; }

  FakeRobot fake_;
  std::vector<Event> events_;
  std::size_t next_ = 0;
};

/// Reports a circle of 20 px around the newest event, and only what it has just been passed.
class NewestEventDetector final : public Detector {
 public:
  void process(std::span<const Event> events, const CameraMotion*) override {
    if (events.empty()) return;
    const Event& newest = events.back();
    estimate_ = {true, false, {static_cast<double>(newest.x), static_cast<double>(newest.y), 20.0}, 1.0};
  }
  void advance_to(std::int64_t, const CameraMotion*) override {}
  [[nodiscard]] Estimate estimate() override { return estimate_; }
  [[nodiscard]] double threshold() const override { return 0.5; }
  [[nodiscard]] RejectedEvents rejected() const override { return {}; }

 private:
  Estimate estimate_;
};

}  // namespace saccade
