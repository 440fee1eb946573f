#pragma once

#include <yarp/os/Port.h>
#include <yarp/os/PortReader.h>
#include <yarp/os/PortReport.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "robot/event_queue.h"
#include "robot/event_timeline.h"
#include "robot/ports.h"
#include "robot/steady_clock.h"
#include "robot/yarp/yarp_config.h"

namespace saccade {

/// Reads one event port of the robot in threads of YARP.
class EventInput final : private yarp::os::PortReader, private yarp::os::PortReport {
 public:
  /// Opens `local` and connects `remote` to it. Throws RunError if `local` cannot be opened.
  EventInput(const std::string& local, std::string remote, const std::string& carrier, double timeout_s,
             const EventTimelineConfig& config, std::size_t capacity, const SteadyClock& clock);
  ~EventInput() override;
  EventInput(const EventInput&) = delete;
  EventInput& operator=(const EventInput&) = delete;

  [[nodiscard]] const std::string& remote() const { return remote_; }
  void pop_until(std::int64_t t_us, std::vector<Event>& events) { queue_.pop_until(t_us, events); }
  /// True if the connection was never made, or is closed.
  [[nodiscard]] bool lost() const { return lost_; }
  /// True after the camera announced its end.
  [[nodiscard]] bool ended() const { return ended_; }
  /// Arrival time of the last readable message; before the first, the time of construction of the robot.
  [[nodiscard]] std::int64_t heard_us() const { return heard_us_; }
  [[nodiscard]] EventTraffic traffic() const;
  /// Number of unreadable messages so far, and the error in the last one.
  [[nodiscard]] std::int64_t unreadable() const { return unreadable_; }
  [[nodiscard]] std::string problem() const;
  /// Messages of other senders than `remote`, which are discarded.
  [[nodiscard]] std::int64_t strangers() const { return strangers_; }
  /// What the events so far show of the camera.
  [[nodiscard]] CameraView view() const;

 private:
  bool read(yarp::os::ConnectionReader& reader) override;
  void report(const yarp::os::PortInfo& info) override;
  void note(std::string_view problem);

  std::string remote_;
  PacketFormat format_;
  const SteadyClock& clock_;
  yarp::os::Port port_;
  EventQueue queue_;
  std::atomic<bool> lost_ = false;
  std::atomic<std::int64_t> heard_us_ = 0;
  std::atomic<std::int64_t> packets_ = 0;
  std::atomic<std::int64_t> dropped_ = 0;
  std::atomic<std::int64_t> unreadable_ = 0;
  std::atomic<std::int64_t> strangers_ = 0;
  std::atomic<bool> ended_ = false;
  std::mutex reading_mutex_;  // of what follows, which YARP's threads alone use
  EventTimeline timeline_;
  std::vector<std::byte> message_;
  EventPacket packet_;
  std::vector<Event> events_;
  mutable std::mutex mutex_;  // of what follows; the tick does not need it
  std::string_view problem_;
  CameraView view_;
};

/// The event camera of the left eye, or of both eyes. Events of two ports are merged. An event up to 5 ms behind the
/// newest delivered one gets its time stamp; an older one is dropped.
class YarpCamera final : public EventSource {
 public:
  YarpCamera(const YarpConfig& config, const SteadyClock& clock);

  [[nodiscard]] ImageSize image_size() const override { return image_size_; }
  PortStatus read_until(std::int64_t t_us, std::vector<Event>& events) override;
  /// `ended` after a camera announced it, as saccade serve does after its duration. heard_us: of the port with the older
  /// last message.
  [[nodiscard]] std::int64_t heard_us() const override;
  [[nodiscard]] EventTraffic traffic() const override;

  [[nodiscard]] const std::vector<std::unique_ptr<EventInput>>& inputs() const { return inputs_; }

 private:
  ImageSize image_size_;
  std::vector<std::unique_ptr<EventInput>> inputs_;
  std::array<std::vector<Event>, 2> came_;  // from each port, where there are two
  ForwardOnly forward_;
  std::int64_t dropped_ = 0;
  bool lost_ = false;
};

}  // namespace saccade
