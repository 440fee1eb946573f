#include "session/detect_events.h"

#include <algorithm>
#include <string>

#include "core/error.h"
#include "loop/loop.h"
#include "robot/replay/replay_robot.h"
#include "session/annotated_ticks.h"
#include "session/observations.h"
#include "session/session.h"

namespace saccade {
namespace {

/// Delivers events of memory as they are. Its clock jumps to any later time at once and ends with the events.
class EventsInMemory final : public Robot, private Clock, private EventSource {
 public:
  EventsInMemory(std::span<const Event> events, ImageSize size, std::int64_t start_us)
      : left_(events), size_(size), now_us_(start_us) {}
  Clock& clock() override { return *this; }
  EventSource& events() override { return *this; }
  HeadPort* head() override { return nullptr; }

 private:
  [[nodiscard]] std::int64_t now_us() const override { return now_us_; }
  PortStatus wait_until(std::int64_t t_us) override {
    if (left_.empty()) return PortStatus::ended;
    now_us_ = std::max(now_us_, t_us);
    return PortStatus::ok;
  }
  [[nodiscard]] ImageSize image_size() const override { return size_; }
  PortStatus read_until(std::int64_t t_us, std::vector<Event>& events) override {
    const auto later = std::ranges::find_if(left_, [&](const Event& event) { return event.t_us > t_us; });
    const auto due = left_.first(static_cast<std::size_t>(later - left_.begin()));
    events.insert(events.end(), due.begin(), due.end());
    left_ = left_.subspan(due.size());
    return left_.empty() ? PortStatus::ended : PortStatus::ok;
  }
  [[nodiscard]] std::int64_t heard_us() const override { return now_us_; }
  [[nodiscard]] EventTraffic traffic() const override { return {}; }

  std::span<const Event> left_;
  ImageSize size_;
  std::int64_t now_us_;
};

/// A detector of somebody else's, in a loop of its own. It does no work ahead, so that its owner may ask it for its estimate.
class BorrowedDetector final : public Detector {
 public:
  explicit BorrowedDetector(Detector& detector) : detector_(detector) {}
  void process(std::span<const Event> events, const CameraMotion* motion) override {
    detector_.process(events, motion);
  }
  void advance_to(std::int64_t now_us, const CameraMotion* motion) override {
    detector_.advance_to(now_us, motion);
  }
  [[nodiscard]] Estimate estimate() override { return detector_.estimate(); }
  [[nodiscard]] double threshold() const override { return detector_.threshold(); }
  [[nodiscard]] RejectedEvents rejected() const override { return detector_.rejected(); }
  [[nodiscard]] std::string_view failure() const override { return detector_.failure(); }

 private:
  Detector& detector_;
};

/// Collects the observations of the first detector.
class Collector final : public LoopObserver {
 public:
  explicit Collector(const Observations& observations) : observations_(observations) {}
  void on_tick(const Tick&) override {
    if (!scoring) return;
    for (const ObservedInstant& instant : observations_.completed()) {
      if (const auto& seen = instant.observations.front()) estimates.push_back({instant.t_us, *seen});
    }
  }

  bool scoring = true;  ///< whether the following ticks are instants of observation
  std::vector<TimedEstimate> estimates;

 private:
  const Observations& observations_;
};

/// Calls ticks(session, collector) for a session over the events.
template <class Ticks>
std::vector<TimedEstimate> detect_in(Detector& detector, const Camera& camera, std::span<const Event> events,
                                     std::int64_t start_us, Ticks ticks) {
  const std::uint8_t eye = events.front().camera;
  const auto other = std::ranges::find_if(events, [&](const Event& event) { return event.camera != eye; });
  if (other != events.end())
    throw InputError("events", "cameras " + std::to_string(eye) + " and " + std::to_string(other->camera),
                     "events of one camera");
  std::int64_t last_us = start_us;
  for (const Event& event : events) {
    check_event_gap("events", last_us, event.t_us);
    last_us = std::max(last_us, event.t_us);
  }
  EventsInMemory robot(events, camera.size, start_us);
  std::vector<LoopDetector> detectors;
  detectors.push_back({"", std::make_unique<BorrowedDetector>(detector)});
  Loop loop(robot, MountedCamera{camera, {}}, std::move(detectors), std::nullopt, static_cast<Eye>(eye));
  Observations observations(loop);
  Collector collector(observations);
  Session session(robot, loop);
  session.add_observer(observations);
  session.add_observer(collector);
  ticks(session, collector);
  return std::move(collector.estimates);
}

}  // namespace

std::vector<TimedEstimate> detect_events(Detector& detector, const Camera& camera,
                                         std::span<const Event> events,
                                         std::optional<std::int64_t> start_us) {
  if (events.empty()) return {};
  const std::int64_t first_us = events.front().t_us;
  const std::int64_t from_us = start_us.value_or(
      first_us - (first_us % observation_tick_us + observation_tick_us) % observation_tick_us);
  return detect_in(detector, camera, events, from_us,
                   [](Session& session, Collector&) { session.run(observation_tick_us); });
}

std::vector<TimedEstimate> detect_events_at(Detector& detector, const Camera& camera,
                                            std::span<const Event> events,
                                            std::span<const std::int64_t> instants_us) {
  if (events.empty()) return {};
  const std::int64_t first_us = events.front().t_us;
  return detect_in(detector, camera, events, first_us, [&](Session& session, Collector& collector) {
    tick_at_annotated(instants_us, first_us, [&](std::int64_t t_us, bool scoring) {
      collector.scoring = scoring;
      return session.tick(t_us);
    });
  });
}

}  // namespace saccade
