#include "robot/yarp/yarp_robot.h"

#include <yarp/conf/version.h>
#include <yarp/os/Network.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <optional>
#include <thread>
#include <utility>

#include "core/error.h"
#include "head/head_model.h"
#include "robot/steady_clock.h"
#include "robot/yarp/yarp_camera.h"
#include "robot/yarp/yarp_gaze.h"
#include "robot/yarp/yarp_head.h"
#include "robot/yarp/yarp_imu.h"
#include "robot/yarp/yarp_network.h"

namespace saccade {
namespace {

constexpr std::int64_t first_packet_us = 1'000'000;
constexpr std::int64_t view_us = 500'000;
constexpr std::int64_t view_events = 1'000;
constexpr auto name_server_period = std::chrono::milliseconds(1000);

/// Compares some events with the configured image and codec. A still scene may send too few of them within the time.
StartUpCheck view_check(const EventInput& input, ImageSize size, const SteadyClock& clock) {
  const std::int64_t until_us = clock.now_us() + view_us;
  while (input.view().events < view_events && clock.now_us() < until_us)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  const CameraView view = input.view();
  const std::string problem = view.problem(size);
  const std::string found = view.events < view_events
                                ? "too few events to compare with: " + std::to_string(view.events)
                                : std::to_string(view.events) + " events fit";
  return {"events of " + input.remote() + " fit the configured camera", problem.empty(),
          problem.empty() ? found : problem};
}

}  // namespace

std::string yarp_version() { return YARP_VERSION; }

void forget_names(const std::vector<std::string>& names) {
  for (const std::string& name : names) yarp::os::NetworkBase::unregisterName(name);
}

struct YarpRobot::Parts {
  /// The robot's clock: while it waits, a target that is due goes out.
  class TickClock final : public Clock {
   public:
    TickClock(SteadyClock& clock, YarpGaze* gaze) : clock_(clock), gaze_(gaze) {}
    [[nodiscard]] std::int64_t now_us() const override { return clock_.now_us(); }
    PortStatus wait_until(std::int64_t t_us) override {
      if (gaze_ != nullptr) gaze_->flush();
      return clock_.wait_until(t_us);
    }

   private:
    SteadyClock& clock_;
    YarpGaze* gaze_;
  };

  Parts(const YarpConfig& config, const JointLimits& limits)
      : network(check_config("yarp", config).timeout_s),
        watch(name_server_period,
              [this, timeout_s = config.timeout_s] { has_name_server = name_server_answers(timeout_s); }) {
    if (port_answers(config.local + "/AE:i", config.timeout_s)) {
      throw RunError("another robot is connected as " + config.local +
                     " already: stop it, or set another yarp.local");
    }
    local = config.local;
    camera.emplace(config, steady);
    if (config.head.control == "joints") head.emplace(config, limits, steady);
    if (config.head.control == "gaze") gaze.emplace(config, limits, steady);
    if (!config.imu.port.empty()) imu.emplace(config, limits.head->head_from_imu, steady);
    clock.emplace(steady, gaze ? &*gaze : nullptr);
    keep_exit_statuses();
  }

  YarpNetwork network;
  SteadyClock steady;
  std::optional<YarpCamera> camera;
  std::optional<YarpHead> head;
  std::optional<YarpGaze> gaze;
  std::optional<YarpImu> imu;
  std::optional<TickClock> clock;
  std::atomic<bool> has_name_server = true;
  Periodic watch;
  bool told_gone = false;
  std::int64_t told_unreadable = 0;
  bool told_strangers = false;
  std::string local;
};

YarpRobot::YarpRobot(const YarpConfig& config, const JointLimits& limits)
    : parts_(std::make_unique<Parts>(config, limits)) {}

YarpRobot::~YarpRobot() = default;

Clock& YarpRobot::clock() { return *parts_->clock; }
EventSource& YarpRobot::events() { return *parts_->camera; }

HeadPort* YarpRobot::head() {
  if (parts_->head) return &*parts_->head;
  return parts_->gaze ? &*parts_->gaze : nullptr;
}

ImuPort* YarpRobot::imu() { return parts_->imu ? &*parts_->imu : nullptr; }

GazePort* YarpRobot::gaze() { return parts_->gaze ? &*parts_->gaze : nullptr; }

std::vector<StartUpCheck> YarpRobot::check() {
  std::vector<StartUpCheck> checks;
  const std::int64_t until_us = parts_->steady.now_us() + first_packet_us;
  for (const auto& input : parts_->camera->inputs()) {
    while (input->traffic().packets == 0 && !input->lost() && input->unreadable() == 0 &&
           parts_->steady.now_us() < until_us) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    const bool heard = input->traffic().packets > 0 && !input->lost();
    std::string found = heard ? std::to_string(input->traffic().packets) + " packets so far"
                              : "connected, but no packet within 1 s";
    if (input->unreadable() > 0) found = "an unreadable message: " + input->problem();
    if (input->lost()) found = "not connected";
    checks.push_back({"event port " + input->remote(), heard && input->unreadable() == 0, found});
    if (heard) checks.push_back(view_check(*input, parts_->camera->image_size(), parts_->steady));
  }
  std::vector<StartUpCheck> more;
  if (parts_->head) more = parts_->head->check();
  if (parts_->gaze) more = parts_->gaze->check();
  for (StartUpCheck& check : more) checks.push_back(std::move(check));
  if (parts_->imu) checks.push_back(parts_->imu->check());
  return checks;
}

void YarpRobot::activate() {
  share_priority();
  if (parts_->head) parts_->head->activate();
  if (parts_->gaze) parts_->gaze->activate();
}

void YarpRobot::release() {
  if (parts_->head) parts_->head->release();
  if (parts_->gaze) parts_->gaze->release();
}

void YarpRobot::halt() {
  if (parts_->head) parts_->head->halt();
  if (parts_->gaze) parts_->gaze->halt();
}

std::vector<std::string> YarpRobot::news() {
  std::vector<std::string> news;
  const bool gone = !parts_->has_name_server;
  if (gone != parts_->told_gone) {
    news.emplace_back(gone ? "the YARP name server is lost; open connections continue"
                           : "the YARP name server is back");
    parts_->told_gone = gone;
  }
  std::int64_t unreadable = 0;
  for (const auto& input : parts_->camera->inputs()) unreadable += input->unreadable();
  if (parts_->told_unreadable == 0 && unreadable > 0) {
    for (const auto& input : parts_->camera->inputs()) {
      if (input->unreadable() > 0)
        news.push_back(input->remote() + " sends unreadable messages: " + input->problem());
    }
  }
  parts_->told_unreadable = unreadable;
  for (const auto& input : parts_->camera->inputs()) {
    if (input->strangers() > 0 && !parts_->told_strangers) {
      news.push_back("another port than " + input->remote() + " sends to " + parts_->local +
                     ": its messages are discarded");
      parts_->told_strangers = true;
    }
  }
  return news;
}

void keep_exit_statuses() { (void)std::signal(SIGCHLD, SIG_DFL); }

struct YarpHeadStopper::Parts {
  Parts(YarpConfig config, const JointLimits& limits) : network(check_config("yarp", config).timeout_s) {
    // Each connection of this process has names of its own: the ports of a board that was lost stay open (YarpHead), and the
    // name server would give the sockets of the same names again.
    static std::atomic<int> connections = 0;
    const int number = ++connections;
    config.local += number == 1 ? "/guard" : "/guard/" + std::to_string(number);
    if (config.head.control == "joints") head.emplace(config, limits, steady);
    if (config.head.control == "gaze") gaze.emplace(config, limits, steady);
  }

  YarpNetwork network;
  SteadyClock steady;
  std::optional<YarpHead> head;
  std::optional<YarpGaze> gaze;
};

YarpHeadStopper::YarpHeadStopper(const YarpConfig& config, const JointLimits& limits)
    : parts_(std::make_unique<Parts>(config, limits)) {}

YarpHeadStopper::~YarpHeadStopper() = default;

bool YarpHeadStopper::is_connected() {
  return parts_->head ? parts_->head->answers() : parts_->gaze && parts_->gaze->answers();
}

bool YarpHeadStopper::stop() {
  return parts_->head ? parts_->head->take_over() : parts_->gaze && parts_->gaze->take_over();
}

}  // namespace saccade
