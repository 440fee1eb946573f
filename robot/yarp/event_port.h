#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/event.h"
#include "recording/address_event.h"
#include "robot/event_packet.h"

namespace saccade {

/// Serves an event camera on YARP like the grabber of event-driven: a port that sends the events since the last message in
/// a PacketFormat, with the time of sending in the envelope. The durations of its messages follow each other without gaps
/// or overlaps. A message has at least one event, since programs of event-driven fail on an empty one: while there are no
/// events, one of the pixel (0, 0) is sent every 20 ms, ON and OFF in turn, like the noise of a sensor, so that readers can
/// see that the camera is connected.
///
/// A slow reader does not delay the sender: events wait for the next message, and above max_waiting the oldest are dropped
/// and counted. Call it from one thread.
class YarpEventPort {
 public:
  struct Config {
    std::string name = "/zynqGrabber/AE:o";
    PacketFormat format = PacketFormat::packet;
    AddressCodec codec = AddressCodec::ev2;
    std::size_t max_waiting = 100'000;  ///< events
    bool swap_polarity =
        false;  ///< the polarity bit 1 means brighter, as with event-driven's bridges to Prophesee cameras; else darker
  };
  /// Throws RunError if YARP cannot open the port: no name server, or the name is in use.
  explicit YarpEventPort(const Config& config);
  ~YarpEventPort();

  /// Sends the events since the last call, sorted by time; now_us is on their clock.
  void send(std::span<const Event> events, std::int64_t now_us);

  /// The last message: its envelope is the word `end`, so that a reader knows that the camera did not fail. Waits up to
  /// 0.2 s until it has gone out.
  void send_end(std::int64_t now_us);

  [[nodiscard]] int readers() const;
  [[nodiscard]] std::int64_t messages() const {
    return messages_;
  }                                                                ///< sent so far, with a reader or without
  [[nodiscard]] std::int64_t dropped() const { return dropped_; }  ///< events dropped so far

 private:
  struct Port;

  Config config_;
  std::unique_ptr<Port> port_;
  std::vector<Event> waiting_;
  EventPacket packet_;
  std::int64_t sent_us_ = 0;  ///< on the events' clock
  bool noise_on_ = false;     ///< polarity of the next noise event
  std::int64_t messages_ = 0;
  std::int64_t dropped_ = 0;
};

}  // namespace saccade
