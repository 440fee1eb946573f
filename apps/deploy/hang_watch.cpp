#include "apps/deploy/hang_watch.h"

#include <pthread.h>

#include <chrono>

#include "apps/deploy/shared_memory.h"

namespace saccade {
namespace {

constexpr auto period = std::chrono::milliseconds(2);
constexpr int watch_priority = 60;  // above the ticks, which it watches

}  // namespace

HangWatch::HangWatch(Robot& robot, const Config& config, std::function<void(std::int64_t)> halted,
                     std::function<void()> end)
    : robot_(robot), config_(config), halted_(std::move(halted)), end_(std::move(end)), thread_([this] {
        work();
      }) {
  sched_param wanted{};
  wanted.sched_priority = watch_priority;
  (void)pthread_setschedparam(thread_.native_handle(), SCHED_FIFO, &wanted);  // as far as it is permitted
}

HangWatch::~HangWatch() {
  over_ = true;
  thread_.join();
}

void HangWatch::work() {
  while (!over_) {
    std::this_thread::sleep_for(period);
    if (!armed_) continue;
    const std::int64_t age_ns = machine_ns() - tick_ns_;
    if (age_ns > config_.bound_ns && fired_after_ns_ == 0) {
      robot_.halt();
      fired_after_ns_ = age_ns;
      if (halted_) halted_(age_ns);
    }
    if (config_.end_after_ns > 0 && age_ns > config_.end_after_ns && end_) end_();
  }
}

void HangWatch::on_tick() { tick_ns_.store(machine_ns(), std::memory_order_release); }

std::optional<Fault> HangWatch::fault() {
  const std::int64_t age_ns = fired_after_ns_;
  if (age_ns == 0) return std::nullopt;
  return Fault{StopCause::tick_hangs, 0, {}, 1e-6 * static_cast<double>(age_ns)};
}

void HangWatch::activating() {
  armed_ = false;
  fired_after_ns_ = 0;
}

void HangWatch::activated() {
  on_tick();
  armed_ = true;
}

}  // namespace saccade
