#include "robot/yarp/yarp_head.h"

#include <yarp/dev/ControlBoardVocabs.h>
#include <yarp/os/Property.h>
#include <yarp/os/Vocab.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <utility>

#include "core/error.h"
#include "core/units.h"

namespace saccade {
namespace {

constexpr double limit_tolerance_deg = 0.01;
constexpr std::int64_t fresh_us = 200'000;
constexpr int longest_first_state_ms = 1000;
constexpr int repeats = 3;
constexpr std::int64_t repeat_after_us = 3'000;
constexpr auto repeat_period = std::chrono::milliseconds(3);

constexpr std::array<int, head_joint_count> axes = {0, 1, 2, 3, 4, 5};

/// Whether a joint in this mode is held by its board, so that it may be taken over and given back.
bool holds(int mode) {
  return mode == VOCAB_CM_POSITION || mode == VOCAB_CM_POSITION_DIRECT || mode == VOCAB_CM_VELOCITY ||
         mode == VOCAB_CM_MIXED;
}

std::string text(const std::array<int, head_joint_count>& modes) {
  std::string text;
  for (const int mode : modes) text += (text.empty() ? "" : " ") + yarp::os::Vocab32::decode(mode);
  return text;
}

std::string text(double value_deg) { return text_of(std::round(value_deg * 100.0) / 100.0); }

}  // namespace

bool answered_within(double timeout_s, std::function<bool()> ask) {
  struct Shared {
    std::mutex mutex;
    std::condition_variable done;
    std::optional<bool> answer;
  };
  const auto shared = std::make_shared<Shared>();
  std::thread([shared, ask = std::move(ask)] {
    const bool answer = ask();
    const std::lock_guard lock(shared->mutex);
    shared->answer = answer;
    shared->done.notify_all();
  }).detach();
  std::unique_lock lock(shared->mutex);
  shared->done.wait_for(lock, std::chrono::duration<double>(timeout_s),
                        [&] { return shared->answer.has_value(); });
  return shared->answer.value_or(false);
}

TorsoInput::TorsoInput(const YarpConfig& config, const SteadyClock& clock) {
  const std::string& part = config.head.torso_part;
  if (part.empty()) return;
  input_ = std::make_unique<StateInput>(config.local + "/torso/state:i", part + "/state:o",
                                        config.head.carrier, config.timeout_s, clock);
}

void TorsoInput::read(HeadState& state) const {
  if (input_ == nullptr) return;
  const StateInput::State torso = input_->state();
  if (torso.count < torso_joint_count) return;
  for (int i = 0; i < torso_joint_count; ++i) {
    const auto sent =
        static_cast<std::size_t>(torso_joint_count - 1 - i);  // the board's order is the other way round
    state.position_rad[i] = torso.value[sent] * rad_per_deg;
    state.velocity_rad_s[i] = torso.rate[sent] * rad_per_deg;
  }
  state.t_us = std::min(state.t_us, torso.t_us);
}

std::vector<StartUpCheck> TorsoInput::check() const {
  if (input_ == nullptr) return {};
  const int count = input_->state().count;
  return {{"torso " + input_->remote(), !input_->lost() && count == torso_joint_count,
           input_->lost() ? "not connected" : std::to_string(count) + " joints, 3 expected"}};
}

YarpHead::YarpHead(const YarpConfig& config, const JointLimits& limits, const SteadyClock& clock)
    : part_(config.head.part),
      timeout_s_(config.timeout_s),
      clock_(clock),
      ours_(limits),
      limits_(limits),
      state_input_(config.local + "/head/state:i", config.head.part + "/state:o", config.head.carrier,
                   config.timeout_s, clock),
      torso_(config, clock) {
  lost_ = state_input_.lost() || !open_board(config);
  if (lost_) {
    board_ = nullptr;
    return;
  }
  for (int i = 0; i < head_joint_count; ++i) {
    const auto at = static_cast<std::size_t>(i);
    double& min_rad = limits_.min_rad[torso_joint_count + i];
    double& max_rad = limits_.max_rad[torso_joint_count + i];
    min_rad = std::max(min_rad, board_->limits_deg[0][at] * rad_per_deg);
    max_rad = std::min(max_rad, board_->limits_deg[1][at] * rad_per_deg);
  }
  commands_ = std::make_unique<OutputWatch>(config.local + "/head/command:o", part_ + "/command:i");
  const std::int64_t until_us = clock_.now_us() + std::llround(config.timeout_s * 1e6);
  while (state_input_.state().count == 0 && clock_.now_us() < until_us) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  if (state_input_.state().count < head_joint_count) lost_ = true;
  repeater_ = std::make_unique<Periodic>(repeat_period, [this] { send_again(); });
}

YarpHead::~YarpHead() { release(); }

bool YarpHead::open_board(const YarpConfig& config) {
  board_ = std::make_shared<Board>();
  yarp::os::Property options;
  options.put("device", yarp::os::Value("remote_controlboard"));
  options.put("remote", yarp::os::Value(part_));
  options.put("local", yarp::os::Value(config.local + "/head"));
  options.put("carrier", yarp::os::Value(config.head.carrier));
  return answered_within(config.timeout_s, [board = board_, options]() mutable {
    Board& b = *board;
    if (!b.driver.open(options) || !b.driver.view(b.encoders) || !b.driver.view(b.limits) ||
        !b.driver.view(b.modes) || !b.driver.view(b.references) || !b.encoders->getAxes(&b.axes) ||
        b.axes < head_joint_count) {
      return false;
    }
    for (int i = 0; i < head_joint_count; ++i) {
      const auto at = static_cast<std::size_t>(i);
      if (!b.limits->getLimits(i, &b.limits_deg[0][at], &b.limits_deg[1][at])) return false;
    }
    int mode = 0;  // it comes with the stream of speeds and modes
    for (int i = 0; !b.modes->getControlMode(0, &mode); ++i) {
      if (i == longest_first_state_ms) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return true;
  });
}

bool YarpHead::is_lost() {
  lost_ = lost_ || state_input_.lost() || torso_.lost() || (commands_ != nullptr && commands_->lost());
  return lost_;
}

PortStatus YarpHead::read(HeadState& state) {
  if (is_lost()) return PortStatus::lost;
  const StateInput::State joints = state_input_.state();
  Degrees speed_deg{};
  state = HeadState{};
  state.t_us = joints.t_us;
  std::array<double, StateInput::most_values> board_speed{};
  const bool has_speeds =
      board_->axes <= StateInput::most_values && board_->encoders->getEncoderSpeeds(board_speed.data());
  std::copy_n((has_speeds ? board_speed : joints.rate).begin(), head_joint_count, speed_deg.begin());
  for (int i = 0; i < head_joint_count; ++i) {
    const auto at = static_cast<std::size_t>(i);
    state.position_rad[torso_joint_count + i] = joints.value[at] * rad_per_deg;
    state.velocity_rad_s[torso_joint_count + i] = speed_deg[at] * rad_per_deg;
  }
  torso_.read(state);
  stop_reference_.update(state);
  return PortStatus::ok;
}

void YarpHead::send(const HeadCommand& reference_rad) {
  const std::lock_guard lock(send_mutex_);
  for (int i = 0; i < head_joint_count; ++i) {
    sent_deg_[static_cast<std::size_t>(i)] = reference_rad[i] / rad_per_deg;
  }
  board_->references->setPositions(head_joint_count, axes.data(), sent_deg_.data());
  sent_us_ = clock_.now_us();
  repeats_left_ = repeats;
}

void YarpHead::send_again() {
  const std::lock_guard lock(send_mutex_);
  if (repeats_left_ == 0 || clock_.now_us() < sent_us_ + repeat_after_us) return;
  board_->references->setPositions(head_joint_count, axes.data(), sent_deg_.data());
  --repeats_left_;
}

HeadPort::CommandResult YarpHead::command(const HeadCommand& reference_rad) {
  if (is_lost()) return {PortStatus::lost, false};
  if (!active_ || !is_allowed(reference_rad, limits_)) return {PortStatus::ok, true};
  send(reference_rad);
  return {};
}

PortStatus YarpHead::stop() {
  if (is_lost()) return PortStatus::lost;
  if (!active_) return PortStatus::ok;
  HeadState state;
  if (read(state) != PortStatus::ok) return PortStatus::lost;
  // While an encoder fails, the head stops at its last finite position.
  const auto reference_rad = stop_reference_.reference_rad(limits_);
  if (!reference_rad) {
    lost_ = true;
    return PortStatus::lost;
  }
  send(*reference_rad);
  return PortStatus::ok;
}

std::optional<YarpHead::Modes> YarpHead::modes() const {
  Modes modes;
  for (std::size_t i = 0; i < modes.size(); ++i) {
    if (!board_->modes->getControlMode(static_cast<int>(i), &modes[i])) return std::nullopt;
  }
  return modes;
}

bool YarpHead::set_modes(const Modes& modes) const {
  const bool asked = answered_within(timeout_s_, [board = board_, wanted = Modes(modes)]() mutable {
    return board->modes->setControlModes(head_joint_count, axes.data(), wanted.data());
  });
  if (!asked) return false;
  const std::int64_t until_us = clock_.now_us() + std::llround(timeout_s_ * 1e6);
  while (this->modes() != modes) {
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
  if (!std::all_of(found->begin(), found->end(), holds)) {
    throw RunError("the head " + part_ + " has joints in modes that do not hold them: " + text(*found));
  }
  found_modes_ = *found;
  Modes direct;
  direct.fill(VOCAB_CM_POSITION_DIRECT);
  if (!set_modes(direct)) {
    (void)set_modes(found_modes_);
    throw RunError("the head " + part_ + " does not change to position-direct mode");
  }
  active_ = true;
  stop();
}

void YarpHead::release() {
  if (!active_) return;
  stop();
  active_ = false;
  {
    const std::lock_guard lock(send_mutex_);
    repeats_left_ = 0;
  }
  if (!state_input_.lost()) (void)set_modes(found_modes_);
}

StartUpCheck YarpHead::limits_check() const {
  std::string found;
  bool passed = true;
  for (int i = 0; i < head_joint_count; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const int joint = torso_joint_count + i;
    const double ours_deg[2] = {ours_.min_rad[joint] / rad_per_deg, ours_.max_rad[joint] / rad_per_deg};
    const double robot_deg[2] = {board_->limits_deg[0][at], board_->limits_deg[1][at]};
    if (robot_deg[0] >= ours_deg[0] - limit_tolerance_deg &&
        robot_deg[1] <= ours_deg[1] + limit_tolerance_deg) {
      continue;
    }
    passed = false;
    found += (found.empty() ? "" : ", ") + std::string(joint_names[static_cast<std::size_t>(joint)]) + " " +
             text(robot_deg[0]) + " to " + text(robot_deg[1]) + ", ours " + text(ours_deg[0]) + " to " +
             text(ours_deg[1]);
  }
  return {"limits of the robot within the configured ones, deg", passed, passed ? "they are" : found};
}

std::vector<StartUpCheck> YarpHead::check() {
  std::vector<StartUpCheck> checks;
  const bool connected = board_ != nullptr && !is_lost();
  checks.push_back(
      {"head " + part_, connected && board_->axes == head_joint_count,
       board_ == nullptr
           ? "no control board answers, or YARP does not find remote_controlboard (YARP_DATA_DIRS)"
       : !connected ? "connected once, now lost"
                    : std::to_string(board_->axes) + " joints, 6 expected"});
  if (connected) {
    const auto found = modes();
    checks.push_back({"joints held by their board", found && std::all_of(found->begin(), found->end(), holds),
                      found ? text(*found) : "the board does not report their modes"});
    HeadState state;
    const bool read_it = read(state) == PortStatus::ok;
    const std::int64_t age_us = clock_.now_us() - state_input_.state().t_us;
    checks.push_back({"joints are read", read_it && is_finite(state) && age_us < fresh_us,
                      "newest reading " + std::to_string(age_us / 1000) + " ms old" +
                          (is_finite(state) ? "" : ", not finite")});
    checks.push_back(limits_check());
  }
  for (StartUpCheck& check : torso_.check()) checks.push_back(std::move(check));
  return checks;
}

}  // namespace saccade
