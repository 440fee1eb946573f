#include "robot/yarp/yarp_gaze.h"

#include <yarp/os/PortInfo.h>
#include <yarp/os/Vocab.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "core/error.h"
#include "core/units.h"
#include "head/head_model.h"
#include "robot/yarp/yarp_network.h"

namespace saccade {
YarpGaze::YarpGaze(const YarpConfig& config, const JointLimits& limits, const SteadyClock& clock)
    : config_(config.gaze_server),
      clock_(clock),
      limits_(limits),
      joints_(config.local + "/gaze/q:i", config_.name + "/q:o", config.head.carrier, config.timeout_s,
              clock),
      sent_us_(clock.now_us() - 1'000'000) {
  const std::string prefix = config.local + "/gaze";
  requests_.asPort().setReporter(request_outputs_);
  if (!targets_.open(prefix + "/xd:o") || !requests_.open(prefix + "/rpc:o")) {
    throw RunError("YARP cannot open the ports " + prefix + "/xd:o and rpc:o");
  }
  requests_.asPort().setTimeout(static_cast<float>(config.timeout_s));
  lost_ = joints_.lost() ||
          !connect_ports(targets_.getName(), config_.name + "/xd:i", config.head.carrier, config.timeout_s) ||
          !connect_ports(requests_.getName(), config_.name + "/rpc", "tcp", config.timeout_s);
  targets_.setReporter(*this);
  const std::int64_t until_us = clock_.now_us() + std::llround(config.timeout_s * 1e6);
  while (!is_lost() && joints_.state().count < static_cast<int>(limits_.head->joints.size())) {
    if (clock_.now_us() > until_us) lost_ = true;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  stopper_ = std::thread([this] { stop_when_told(); });
}

YarpGaze::~YarpGaze() {
  release();
  ending_ = true;
  stop_wanted_.request();
  stopper_.join();
  targets_.interrupt();
  targets_.close();
  requests_.interrupt();
  requests_.close();
}

bool YarpGaze::answers() { return !is_lost() && clock_.now_us() - joints_.state().t_us < fresh_us; }

bool YarpGaze::is_lost() {
  if (joints_.lost()) lost_ = true;
  return lost_;
}

void YarpGaze::report(const yarp::os::PortInfo& info) {
  const bool closed = info.tag == yarp::os::PortInfo::PORTINFO_CONNECTION && !info.incoming && !info.created;
  if (closed && info.targetName == config_.name + "/xd:i") lost_ = true;
}

PortStatus YarpGaze::look_at(const Eigen::Vector3d& target_m) {
  if (is_lost()) return PortStatus::lost;
  if (!active_ || halted_ || !target_m.allFinite()) return PortStatus::ok;
  waiting_m_ = target_m;
  flush();
  return PortStatus::ok;
}

void YarpGaze::flush() {
  const std::int64_t now_us = clock_.now_us();
  if (halted_) waiting_m_.reset();
  if (!waiting_m_ || static_cast<double>(now_us - sent_us_) < config_.target_interval_ms * 1e3) return;
  if (targets_.isWriting()) return;  // it waits for the next tick
  yarp::os::Bottle& message = targets_.prepare();
  message.clear();
  for (int i = 0; i < 3; ++i) message.addFloat64((*waiting_m_)[i]);
  targets_.write();
  waiting_m_.reset();
  sent_us_ = now_us;
  if (halted_) stop_wanted_.request();  // a tick that hung in here has sent a target after the stop
}

PortStatus YarpGaze::stop() {
  if (is_lost()) return PortStatus::lost;
  if (!active_) return PortStatus::ok;
  waiting_m_.reset();
  stop_wanted_.request();
  return PortStatus::ok;
}

void YarpGaze::halt() {
  halted_ = true;
  stop_wanted_.request();
}

void YarpGaze::stop_when_told() {
  for (;;) {
    stop_wanted_.wait();
    if (ending_) return;
    (void)ask("stop");
  }
}

PortStatus YarpGaze::read(HeadState& state) {
  if (is_lost()) return PortStatus::lost;
  const StateInput::State joints = joints_.state();
  state.t_us = joints.t_us;
  for (std::size_t i = 0; i < limits_.head->joints.size(); ++i) {
    const int slot = limits_.head->joints[i].slot;
    state.position_rad[slot] = joints.value[i] * rad_per_deg;
    state.velocity_rad_s[slot] = joints.rate[i] * rad_per_deg;
  }
  return PortStatus::ok;
}

HeadPort::CommandResult YarpGaze::command(const HeadCommand&) {
  return {is_lost() ? PortStatus::lost : PortStatus::ok, true};
}

std::optional<yarp::os::Bottle> YarpGaze::ask(const std::string& request) {
  const std::lock_guard lock(ask_mutex_);
  yarp::os::Bottle message(request);
  yarp::os::Bottle reply;
  if (request_outputs_.count() == 0 || !requests_.write(message, reply)) return std::nullopt;
  const bool acknowledged =
      reply.size() > 0 && (reply.get(0).asVocab32() == yarp::os::createVocab32('a', 'c', 'k') ||
                           reply.get(0).asString() == "ack");
  if (!acknowledged) return std::nullopt;
  return reply.tail();
}

std::string YarpGaze::settings_refused() {
  std::vector<std::string> settings = {"set Tneck " + text_of(config_.neck_time_s),
                                       "set Teyes " + text_of(config_.eyes_time_s),
                                       std::string("set track ") + (config_.tracking ? "1" : "0"),
                                       std::string("set sacc ") + (config_.saccades ? "1" : "0")};
  if (config_.bind_roll) settings.emplace_back("bind roll 0.0 0.0");
  settings.emplace_back("run");
  for (const std::string& setting : settings) {
    if (!ask(setting)) return setting;
  }
  return {};
}

void YarpGaze::activate() {
  if (active_) return;
  if (is_lost()) throw RunError("the gaze controller " + config_.name + " is not connected");
  const auto context = ask("stor");
  if (!context) throw RunError("the gaze controller " + config_.name + " does not store its settings (stor)");
  context_ = context->get(0).asInt32();
  halted_ = false;
  active_ = true;
  const std::string refused = settings_refused();
  if (refused.empty()) return;
  release();
  throw RunError("the gaze controller " + config_.name + " rejects \"" + refused + "\"");
}

void YarpGaze::release() {
  if (!active_) return;
  active_ = false;
  waiting_m_.reset();
  if (request_outputs_.count() == 0) return;
  (void)ask("stop");
  const std::string id = std::to_string(*context_);
  (void)ask("rest " + id);
  (void)ask("del " + id);
}

std::vector<StartUpCheck> YarpGaze::check() {
  const std::string what = "gaze controller " + config_.name;
  if (is_lost()) return {{what, false, "not connected, or it does not stream joints"}};
  const auto status = ask("status");
  std::vector<StartUpCheck> checks = {
      {what, status.has_value(), status ? "it answers: " + status->toString() : "it does not answer"}};
  HeadState state;
  const bool is_read = read(state) == PortStatus::ok && is_finite(state);
  const std::int64_t age_us = clock_.now_us() - state.t_us;
  checks.push_back({"joints are read from " + joints_.remote(), is_read && age_us < fresh_us,
                    "newest reading " + std::to_string(age_us / 1000) + " ms old"});
  return checks;
}

}  // namespace saccade
