#include "robot/yarp/yarp_head.h"

#include <pthread.h>
#include <yarp/dev/ControlBoardVocabs.h>
#include <yarp/os/Network.h>
#include <yarp/os/Property.h>
#include <yarp/os/Vocab.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <mutex>
#include <thread>
#include <utility>

#include "core/error.h"
#include "core/units.h"
#include "robot/head_limits.h"
#include "robot/stop_reference.h"

namespace saccade {
namespace {

constexpr int longest_first_state_ms = 1000;
constexpr int repeats = 3;
constexpr auto repeat_after = std::chrono::milliseconds(3);
constexpr auto report_period = std::chrono::milliseconds(5);

constexpr std::array<int, gaze_slots> axes = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11};

/// Whether a joint in this mode is held by its board, so that it may be taken over and given back.
bool holds(int mode) {
  return mode == VOCAB_CM_POSITION || mode == VOCAB_CM_POSITION_DIRECT || mode == VOCAB_CM_VELOCITY ||
         mode == VOCAB_CM_MIXED;
}

std::string text(std::span<const int> modes) {
  std::string text;
  for (const int mode : modes) text += (text.empty() ? "" : " ") + yarp::os::Vocab32::decode(mode);
  return text;
}

JointDrive drive_of(int mode) {
  switch (mode) {
    case VOCAB_CM_POSITION_DIRECT:
      return JointDrive::references;
    case VOCAB_CM_IDLE:
    case VOCAB_CM_FORCE_IDLE:
    case VOCAB_CM_NOT_CONFIGURED:
    case VOCAB_CM_CONFIGURED:
      return JointDrive::off;
    case VOCAB_CM_HW_FAULT:
      return JointDrive::fault;
    case VOCAB_CM_UNKNOWN:
      return JointDrive::unknown;
    default:
      return JointDrive::held;
  }
}

}  // namespace

void end_without_destructors() {
  const auto end = [](int status, void*) {
    std::fflush(nullptr);
    std::_Exit(status);
  };
  (void)::on_exit(end, nullptr);  // runs before the destructors of what exists by now
}

bool answered_within(double timeout_s, std::function<bool()> ask) {
  struct Shared {
    std::mutex mutex;
    std::condition_variable done;
    std::optional<bool> answer;
  };
  const auto shared = std::make_shared<Shared>();
  std::thread([shared, ask = std::move(ask)]() mutable {
    const bool answer = ask();
    {
      const std::lock_guard lock(shared->mutex);
      shared->answer = answer;
      shared->done.notify_all();
    }
    ask = nullptr;
  }).detach();
  std::unique_lock lock(shared->mutex);
  shared->done.wait_for(lock, std::chrono::duration<double>(timeout_s),
                        [&] { return shared->answer.has_value(); });
  if (shared->answer) return *shared->answer;
  end_without_destructors();  // the thread uses what YARP has made
  return false;
}

TorsoInput::TorsoInput(const YarpConfig& config, const HeadModel& head, const SteadyClock& clock)
    : motors_(head.torso_motors) {
  const std::string& part = config.head.torso_part;
  if (part.empty() || motors_.empty()) return;
  input_ = std::make_unique<StateInput>(config.local + "/torso/state:i", part + "/state:o",
                                        config.head.carrier, config.timeout_s, clock);
}

void TorsoInput::read(HeadState& state) const {
  if (input_ == nullptr) return;
  const StateInput::State torso = input_->state();
  if (torso.count < static_cast<int>(motors_.size())) return;
  for (std::size_t i = 0; i < motors_.size(); ++i) {
    state.position_rad[motors_[i]] = torso.value[i] * rad_per_deg;
    state.velocity_rad_s[motors_[i]] = torso.rate[i] * rad_per_deg;
  }
  state.t_us = std::min(state.t_us, torso.t_us);
}

std::vector<StartUpCheck> TorsoInput::check() const {
  if (input_ == nullptr) return {};
  const int count = input_->state().count;
  return {{"torso " + input_->remote(), !input_->lost() && count == static_cast<int>(motors_.size()),
           input_->lost()
               ? "not connected"
               : std::to_string(count) + " joints, " + std::to_string(motors_.size()) + " expected"}};
}

YarpHead::YarpHead(const YarpConfig& config, const JointLimits& limits, const SteadyClock& clock)
    : part_(config.head.part),
      timeout_s_(config.timeout_s),
      clock_(clock),
      limits_(limits),
      joints_(limits.head->gaze_joints()),
      state_input_(config.local + "/head/state:i", config.head.part + "/state:o", config.head.carrier,
                   config.timeout_s, clock),
      torso_(config, *limits.head, clock) {
  lost_ = state_input_.lost() || !open_board(config);
  if (lost_) {
    board_ = nullptr;
    return;
  }
  JointLimits robots = limits;
  for (int i = 0; i < joints_; ++i) {
    const auto at = static_cast<std::size_t>(i);
    robots.min_rad[torso_slots + i] = board_->limits_deg[0][at] * rad_per_deg;
    robots.max_rad[torso_slots + i] = board_->limits_deg[1][at] * rad_per_deg;
  }
  const CommonLimits common = common_limits(limits, robots);
  limits_ = common.limits;
  limits_check_ = common.check;
  commands_ = std::make_unique<OutputWatch>(config.local + "/head/command:o", part_ + "/command:i");
  const std::int64_t until_us = clock_.now_us() + std::llround(config.timeout_s * 1e6);
  while (state_input_.state().count == 0 && clock_.now_us() < until_us) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  if (state_input_.state().count < joints_) lost_ = true;
  read_reports();
  reporter_ = std::make_unique<Periodic>(report_period, [this] { read_reports(); });
  sender_ = std::thread([this] { send_references(); });
}

YarpHead::~YarpHead() {
  release();
  if (!sender_.joinable()) return;
  sends_ = false;
  to_send_.request();
  sender_.join();
  // YARP 3.12 ends the program with a segmentation fault if it closes a port whose connection was cut while a message was
  // on its way: the board's ports then stay open until the program ends, and their threads run.
  if (!commands_->lost()) return;
  (void)new std::shared_ptr<Board>(board_);
  end_without_destructors();
}

bool YarpHead::open_board(const YarpConfig& config) {
  board_ = std::make_shared<Board>();
  yarp::os::Property options;
  options.put("device", yarp::os::Value("remote_controlboard"));
  options.put("remote", yarp::os::Value(part_));
  options.put("local", yarp::os::Value(config.local + "/head"));
  options.put("carrier", yarp::os::Value(config.head.carrier));
  const std::string stream = config.local + "/head/stateExt:i";
  return answered_within(config.timeout_s, [board = board_, options, joints = joints_, stream]() mutable {
    Board& b = *board;
    if (!b.driver.open(options) || !b.driver.view(b.encoders) || !b.driver.view(b.limits) ||
        !b.driver.view(b.modes) || !b.driver.view(b.references) || !b.encoders->getAxes(&b.axes) ||
        b.axes < joints) {
      return false;
    }
    for (int i = 0; i < joints; ++i) {
      const auto at = static_cast<std::size_t>(i);
      if (!b.limits->getLimits(i, &b.limits_deg[0][at], &b.limits_deg[1][at])) return false;
    }
    int mode = 0;  // it comes with the stream of speeds and modes
    for (int i = 0; !b.modes->getControlMode(0, &mode); ++i) {
      if (i == longest_first_state_ms) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    // This port is YARP's, and believes what anybody sends to it: without its name no other program finds it. The robot stays
    // connected.
    yarp::os::Network::unregisterName(stream);
    return true;
  });
}

bool YarpHead::is_lost() {
  if (state_input_.lost() || torso_.lost() || (commands_ != nullptr && commands_->lost())) lost_ = true;
  return lost_;
}

void YarpHead::read_reports() {
  const std::lock_guard lock(reports_mutex_);
  Reports reports;
  std::array<double, StateInput::most_values> speed_deg_s{};
  reports.has_speeds =
      board_->axes <= StateInput::most_values && board_->encoders->getEncoderSpeeds(speed_deg_s.data());
  std::copy_n(speed_deg_s.begin(), joints_, reports.speed_deg_s.begin());
  if (const auto found = modes()) {
    reports.modes = *found;
    reports.has_modes = true;
  }
  reports_.write(reports);
}

PortStatus YarpHead::read(HeadState& state) {
  if (is_lost()) return PortStatus::lost;
  const StateInput::State joints = state_input_.state();
  const Reports reports = reports_.read();
  state = HeadState{};
  state.t_us = joints.t_us;
  for (int i = 0; i < joints_; ++i) {
    const auto at = static_cast<std::size_t>(i);
    state.position_rad[torso_slots + i] = joints.value[at] * rad_per_deg;
    state.velocity_rad_s[torso_slots + i] =
        (reports.has_speeds ? reports.speed_deg_s[at] : joints.rate[at]) * rad_per_deg;
  }
  torso_.read(state);
  return PortStatus::ok;
}

HeadDrives YarpHead::drives() const {
  const Reports reports = reports_.read();
  HeadDrives drives;
  for (std::size_t i = 0; i < static_cast<std::size_t>(joints_); ++i)
    drives.joints[i] = reports.has_modes ? drive_of(reports.modes[i]) : JointDrive::unknown;
  return drives;
}

void YarpHead::set_positions(const Degrees& reference_deg) const {
  board_->references->setPositions(joints_, axes.data(), reference_deg.data());
}

void YarpHead::send_references() {
  int repeats_left = 0;
  for (;;) {
    const bool is_new = repeats_left > 0 ? to_send_.wait_for(repeat_after) : (to_send_.wait(), true);
    if (!sends_) return;
    if (is_new) {
      repeats_left = repeats;
    } else {
      --repeats_left;
      if (!repeats_) continue;
    }
    if (const auto reference_deg = outlet_.to_send()) set_positions(*reference_deg);
  }
}

YarpHead::Degrees YarpHead::in_degrees(const HeadCommand& reference_rad) const {
  Degrees reference_deg{};
  for (int i = 0; i < joints_; ++i)
    reference_deg[static_cast<std::size_t>(i)] = reference_rad[i] / rad_per_deg;
  return reference_deg;
}

void YarpHead::send(const HeadCommand& reference_rad) {
  outlet_.command(in_degrees(reference_rad));
  to_send_.request();
}

HeadPort::CommandResult YarpHead::command(const HeadCommand& reference_rad) {
  if (is_lost()) return {PortStatus::lost, false};
  if (!active_ || outlet_.halted() || !is_allowed(reference_rad, limits_)) return {PortStatus::ok, true};
  send(reference_rad);
  return {};
}

std::optional<HeadCommand> YarpHead::stop_reference() const {
  const StateInput::State joints = state_input_.state();
  const auto sent_deg = outlet_.commanded();
  return saccade::stop_reference({joints.value.data(), static_cast<std::size_t>(joints.count)},
                                 sent_deg ? std::span<const double>(*sent_deg) : std::span<const double>(),
                                 joints_, limits_);
}

PortStatus YarpHead::stop() {
  const PortStatus status = is_lost() ? PortStatus::lost : PortStatus::ok;
  if (!active_ || outlet_.halted()) return status;
  const auto reference_rad = stop_reference();
  if (!reference_rad) {
    lost_ = true;
    return PortStatus::lost;
  }
  send(*reference_rad);  // another connection than the lost one may still be open
  return status;
}

void YarpHead::halt() {
  outlet_.halt();  // first, whatever is known of the joints
  if (board_ == nullptr) return;
  if (const auto reference_rad = stop_reference()) {
    outlet_.hold_at(in_degrees(*reference_rad));
    to_send_.request();
  }
}

std::optional<YarpHead::Modes> YarpHead::modes() const {
  Modes modes{};
  for (std::size_t i = 0; i < static_cast<std::size_t>(joints_); ++i) {
    if (!board_->modes->getControlMode(static_cast<int>(i), &modes[i])) return std::nullopt;
  }
  return modes;
}

bool YarpHead::set_modes(const Modes& now, const Modes& wanted) const {
  std::vector<int> joints;
  std::vector<int> values;
  for (std::size_t i = 0; i < static_cast<std::size_t>(joints_); ++i) {
    if (now[i] == wanted[i]) continue;
    joints.push_back(static_cast<int>(i));
    values.push_back(wanted[i]);
  }
  if (joints.empty()) return true;
  const bool asked = answered_within(timeout_s_, [board = board_, joints, values]() mutable {
    return board->modes->setControlModes(static_cast<int>(joints.size()), joints.data(), values.data());
  });
  if (!asked) return false;
  const std::int64_t until_us = clock_.now_us() + std::llround(timeout_s_ * 1e6);
  const auto reached = [&] {
    const auto found = modes();
    return found && std::ranges::all_of(joints, [&](int joint) {
             return (*found)[static_cast<std::size_t>(joint)] == wanted[static_cast<std::size_t>(joint)];
           });
  };
  while (!reached()) {
    if (clock_.now_us() > until_us) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return true;
}

void YarpHead::activate() {
  if (active_) return;
  if (is_lost()) throw RunError("the head " + part_ + " is not connected");
  const auto found = modes();
  if (!found) throw RunError("the head " + part_ + " does not report the modes of its joints");
  if (!std::ranges::all_of(used(*found), holds)) {
    throw RunError("the head " + part_ + " has joints in modes that do not hold them: " + text(used(*found)));
  }
  found_modes_ = *found;
  Modes direct;
  direct.fill(VOCAB_CM_POSITION_DIRECT);
  if (!set_modes(*found, direct)) {
    active_ = true;
    release();
    throw RunError("the head " + part_ + " does not change to position-direct mode");
  }
  read_reports();
  sched_param priority{};  // references are as urgent as the ticks that compute them
  int policy = 0;
  if (pthread_getschedparam(pthread_self(), &policy, &priority) == 0)
    (void)pthread_setschedparam(sender_.native_handle(), policy, &priority);
  outlet_.resume();
  repeats_ = true;
  active_ = true;
  stop();
}

void YarpHead::release() {
  if (!active_) return;
  stop();
  active_ = false;
  repeats_ = false;
  const auto now = modes();
  if (!now) return;
  Modes wanted = *now;
  for (std::size_t i = 0; i < static_cast<std::size_t>(joints_); ++i) {
    // A joint that somebody switched off, or moves, meanwhile stays as it is.
    if (wanted[i] == VOCAB_CM_POSITION_DIRECT) wanted[i] = found_modes_[i];
  }
  (void)set_modes(*now, wanted);
}

bool YarpHead::answers() { return !is_lost() && clock_.now_us() - state_input_.state().t_us < fresh_us; }

bool YarpHead::take_over() {
  if (is_lost()) return false;
  const auto now = modes();
  const auto reference_rad = stop_reference();
  if (!now) return false;
  if (reference_rad) set_positions(in_degrees(*reference_rad));
  Modes wanted = *now;
  for (int& mode : wanted) {
    if (mode == VOCAB_CM_POSITION_DIRECT) mode = VOCAB_CM_POSITION;
  }
  return set_modes(*now, wanted);
}

std::vector<StartUpCheck> YarpHead::check() {
  std::vector<StartUpCheck> checks;
  const bool connected = board_ != nullptr && !is_lost();
  checks.push_back(
      {"head " + part_, connected && board_->axes == joints_,
       board_ == nullptr
           ? "no control board answers, or YARP does not find remote_controlboard (YARP_DATA_DIRS)"
       : !connected ? "connected once, now lost"
                    : std::to_string(board_->axes) + " joints, " + std::to_string(joints_) + " expected"});
  if (connected) {
    const auto found = modes();
    checks.push_back({"joints held by their board", found && std::ranges::all_of(used(*found), holds),
                      found ? text(used(*found)) : "the board does not report their modes"});
    HeadState state;
    const bool read_it = read(state) == PortStatus::ok;
    const std::int64_t age_us = clock_.now_us() - state_input_.state().t_us;
    checks.push_back({"joints are read", read_it && is_finite(state) && age_us < fresh_us,
                      "newest reading " + std::to_string(age_us / 1000) + " ms old" +
                          (is_finite(state) ? "" : ", not finite")});
    checks.push_back(limits_check_);
  }
  for (StartUpCheck& check : torso_.check()) checks.push_back(std::move(check));
  return checks;
}

}  // namespace saccade
