#include "robot/yarp/yarp_camera.h"

#include <yarp/os/ConnectionReader.h>
#include <yarp/os/PortInfo.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "core/error.h"
#include "robot/yarp/state_input.h"
#include "robot/yarp/yarp_network.h"

namespace saccade {
namespace {

constexpr std::size_t longest_message = 4 << 20;  // bytes: half a million events

}  // namespace

EventInput::EventInput(const std::string& local, std::string remote, const std::string& carrier,
                       double timeout_s, const EventTimelineConfig& config, std::size_t capacity,
                       const SteadyClock& clock)
    : remote_(std::move(remote)),
      format_(config.format),
      clock_(clock),
      queue_(capacity),
      heard_us_(clock.now_us()),
      timeline_(config) {
  port_.setReader(*this);
  port_.setReporter(*this);
  if (!port_.open(local)) throw RunError("YARP cannot open the port " + local);
  if (!connect_ports(remote_, port_.getName(), carrier, timeout_s)) lost_ = true;
}

EventInput::~EventInput() { close_input(port_, remote_); }

EventTraffic EventInput::traffic() const { return {packets_, queue_.size(), queue_.dropped() + dropped_}; }

std::string EventInput::problem() const {
  const std::lock_guard lock(mutex_);
  return std::string(problem_);
}

bool EventInput::read(yarp::os::ConnectionReader& reader) {
  if (!reader.isValid()) return false;
  const std::size_t size = reader.getSize();
  std::string_view problem;
  if (reader.getRemoteContact().getName() != remote_) {
    ++strangers_;
    discard(reader);
    return false;
  }
  adopt_priority();
  if (reader.isTextMode()) problem = "a message in text";
  if (size > longest_message) problem = "a message of more than 4 MB";
  if (!problem.empty()) {
    note(problem);
    skip_message(reader);
    return false;
  }
  const std::lock_guard reading(reading_mutex_);  // of YARP's threads alone
  message_.resize(size);
  if (!reader.expectBlock(reinterpret_cast<char*>(message_.data()), size)) return false;
  const std::int64_t arrival_us = clock_.now_us();
  const yarp::os::Bytes envelope = reader.readEnvelope();
  if (std::string_view(envelope.get(), envelope.length()).starts_with(end_of_camera)) ended_ = true;
  problem = read_packet(message_, format_, packet_);
  if (!problem.empty()) {
    note(problem);
    return true;
  }
  events_.clear();
  timeline_.add(packet_, sent_us(reader), arrival_us, events_);
  queue_.push(events_);
  dropped_ = timeline_.dropped();
  const std::lock_guard lock(mutex_);
  view_ = timeline_.view();
  ++packets_;
  heard_us_ = arrival_us;
  return true;
}

CameraView EventInput::view() const {
  const std::lock_guard lock(mutex_);
  return view_;
}

void EventInput::note(std::string_view problem) {
  const std::lock_guard lock(mutex_);
  problem_ = problem;
  ++unreadable_;
}

void EventInput::report(const yarp::os::PortInfo& info) {
  const bool closed = info.tag == yarp::os::PortInfo::PORTINFO_CONNECTION && info.incoming && !info.created;
  if (closed && info.sourceName == remote_) lost_ = true;
}

YarpCamera::YarpCamera(const YarpConfig& config, const SteadyClock& clock) {
  EventTimelineConfig timeline = timeline_config(config.camera);
  image_size_ = timeline.image_size;
  const bool two = !config.camera.right_port.empty();
  const auto add = [&](const char* name, const std::string& remote, std::uint8_t camera) {
    if (two) timeline.camera = camera;
    inputs_.push_back(
        std::make_unique<EventInput>(config.local + name, remote, config.camera.carrier, config.timeout_s,
                                     timeline, static_cast<std::size_t>(config.camera.queue_events), clock));
  };
  add("/AE:i", config.camera.port, 0);
  if (!two) return;
  add("/right/AE:i", config.camera.right_port, 1);
  for (std::vector<Event>& came : came_) came.reserve(static_cast<std::size_t>(config.camera.queue_events));
}

PortStatus YarpCamera::read_until(std::int64_t t_us, std::vector<Event>& events) {
  for (const auto& input : inputs_) {
    if (input->ended()) return PortStatus::ended;
    lost_ = lost_ || input->lost();
  }
  if (lost_) return PortStatus::lost;
  if (inputs_.size() == 1) {
    inputs_.front()->pop_until(t_us, events);
    return PortStatus::ok;
  }
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    came_[i].clear();
    inputs_[i]->pop_until(t_us, came_[i]);
  }
  const auto first = static_cast<std::ptrdiff_t>(events.size());
  std::merge(came_[0].begin(), came_[0].end(), came_[1].begin(), came_[1].end(), std::back_inserter(events),
             [](const Event& a, const Event& b) { return a.t_us < b.t_us; });
  const auto kept = std::remove_if(events.begin() + first, events.end(),
                                   [&](Event& event) { return !forward_.admit(event); });
  dropped_ += events.end() - kept;
  events.erase(kept, events.end());
  return PortStatus::ok;
}

std::int64_t YarpCamera::heard_us() const {
  std::int64_t heard_us = inputs_.front()->heard_us();
  for (const auto& input : inputs_) heard_us = std::min(heard_us, input->heard_us());
  return heard_us;
}

EventTraffic YarpCamera::traffic() const {
  EventTraffic sum{0, 0, dropped_};
  for (const auto& input : inputs_) {
    const EventTraffic traffic = input->traffic();
    sum.packets += traffic.packets;
    sum.queued += traffic.queued;
    sum.dropped += traffic.dropped;
  }
  return sum;
}

}  // namespace saccade
