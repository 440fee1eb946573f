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

/// An event camera as event-driven's grabber offers it: a port that sends what came since the last message, in the words
/// of PacketFormat, with the time of sending in the envelope. A message without events is a message too: who reads knows
/// that the camera is there.
///
/// A reader who is slower than the camera delays nobody: events wait for the next message, and above max_waiting the
/// oldest are left out and counted. Used from one thread.
class YarpEventPort {
 public:
  struct Config {
    std::string name = "/zynqGrabber/AE:o";
    PacketFormat format = PacketFormat::packet;
    AddressCodec codec = AddressCodec::ev2;
    std::size_t max_waiting = 100'000;  ///< events
  };
  /// Throws RunError where YARP opens no port of that name: no name server, or the name is taken.
  explicit YarpEventPort(const Config& config);
  ~YarpEventPort();

  /// The events that came since the last call, sorted by time, now_us on their clock.
  void send(std::span<const Event> events, std::int64_t now_us);

  [[nodiscard]] int readers() const;
  [[nodiscard]] std::int64_t messages() const {
    return messages_;
  }                                                                ///< sent so far, with a reader or without
  [[nodiscard]] std::int64_t dropped() const { return dropped_; }  ///< events left out so far

 private:
  struct Port;

  Config config_;
  std::unique_ptr<Port> port_;
  std::vector<Event> waiting_;
  EventPacket packet_;
  std::int64_t sent_us_ = 0;  ///< on the events' clock
  std::int64_t messages_ = 0;
  std::int64_t dropped_ = 0;
};

}  // namespace saccade
