#include "robot/yarp/event_port.h"

#include <yarp/os/Bottle.h>
#include <yarp/os/BufferedPort.h>
#include <yarp/os/ConnectionReader.h>
#include <yarp/os/ConnectionWriter.h>
#include <yarp/os/Portable.h>
#include <yarp/os/Stamp.h>
#include <yarp/os/Time.h>

#include <algorithm>

#include "core/error.h"
#include "robot/yarp/yarp_network.h"

namespace saccade {
namespace {

constexpr std::int64_t least_duration_us = 1;  // a packet has to have one
constexpr std::int64_t noise_period_us = 20'000;
constexpr int longest_end_ms = 100;
constexpr std::uint32_t stamp_mask = (1U << 30) - 1;

/// A whole message as it goes over the wire.
class Message final : public yarp::os::Portable {
 public:
  std::vector<std::byte> bytes;

  bool read(yarp::os::ConnectionReader&) override { return false; }
  bool write(yarp::os::ConnectionWriter& writer) const override {
    writer.appendBlock(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    writer.convertTextMode();  // for who reads text
    return !writer.isError();
  }
};

}  // namespace

struct YarpEventPort::Port {
  YarpNetwork network{name_server_timeout_s};
  OutputCount readers;  // outlives the port
  yarp::os::BufferedPort<Message> port;
  yarp::os::Stamp stamp;
};

YarpEventPort::YarpEventPort(const Config& config) : config_(config), port_(std::make_unique<Port>()) {
  port_->port.setOutputMode(true);
  port_->port.setInputMode(false);
  port_->port.setReporter(port_->readers);
  if (!port_->port.open(config.name)) {
    throw RunError("YARP cannot open the port " + config.name + ": is the name in use?");
  }
}

YarpEventPort::~YarpEventPort() {
  port_->port.interrupt();
  port_->port.close();
}

int YarpEventPort::readers() const { return port_->readers.count(); }

void YarpEventPort::send(std::span<const Event> events, std::int64_t now_us) {
  if (readers() == 0) {
    waiting_.clear();
    sent_us_ = now_us;
    return;
  }
  waiting_.insert(waiting_.end(), events.begin(), events.end());
  if (port_->port.isWriting()) {
    if (waiting_.size() > config_.max_waiting) {
      const std::size_t excess = waiting_.size() - config_.max_waiting;
      dropped_ += static_cast<std::int64_t>(excess);
      waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(excess));
    }
    return;
  }
  if (waiting_.empty()) {
    if (now_us - sent_us_ < noise_period_us) return;
    noise_on_ = !noise_on_;
    waiting_.push_back({now_us, 0, 0, noise_on_, 0});
  }
  packet_.duration_us = std::max(now_us - sent_us_, least_duration_us);
  packet_.events.clear();
  const std::int64_t ns = tick_ns(config_.codec);
  for (Event event : waiting_) {
    if (config_.swap_polarity) event.on = !event.on;
    const auto ticks = static_cast<std::uint64_t>(ticks_from_us(event.t_us, ns));
    packet_.events.push_back(
        {has_stamps(config_.format) ? static_cast<std::uint32_t>(ticks & stamp_mask) : 0U,
         encode_address(event, config_.codec)});
  }
  waiting_.clear();
  write_packet(packet_, config_.format, port_->port.prepare().bytes);
  port_->stamp.update(yarp::os::Time::now());
  port_->port.setEnvelope(port_->stamp);
  port_->port.write();
  sent_us_ = now_us;
  ++messages_;
}

void YarpEventPort::send_end(std::int64_t now_us) {
  if (readers() == 0) return;
  for (int i = 0; i < longest_end_ms && port_->port.isWriting(); ++i) yarp::os::Time::delay(0.001);
  packet_.duration_us = std::max(now_us - sent_us_, least_duration_us);
  packet_.events.assign(1, {0, encode_address({now_us, 0, 0, true, 0}, config_.codec)});
  write_packet(packet_, config_.format, port_->port.prepare().bytes);
  yarp::os::Bottle end(end_of_camera);
  port_->port.setEnvelope(end);
  port_->port.write();
  for (int i = 0; i < longest_end_ms && port_->port.isWriting(); ++i) yarp::os::Time::delay(0.001);
}

}  // namespace saccade
