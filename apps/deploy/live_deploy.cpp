#include "apps/deploy/live_deploy.h"

#include <algorithm>

namespace saccade {
namespace {

double ms(std::int64_t us) { return 1e-3 * static_cast<double>(us); }
/// What arrives while the tick ends has no age.
double age_ms(std::int64_t now_us, std::int64_t t_us) { return std::max(0.0, ms(now_us - t_us)); }

}  // namespace

LiveDeploy::LiveDeploy(DeployObserver& recorder, LiveServer* server, LiveRun run,
                       const WatchdogConfig& watchdog, Robot& robot, const Loop& loop)
    : recorder_(recorder), robot_(robot) {
  if (server == nullptr) return;
  run.can_stop = true;
  run.watchdogs = {{"tick late", "late", watchdog.tick_late_ms},
                   {"camera silent", "camera_age", watchdog.camera_silent_ms}};
  if (robot.head() != nullptr)
    run.watchdogs.push_back({"joints stale", "joints_age", watchdog.joints_stale_ms});
  feed_.emplace(*server, std::move(run), loop);
}

void LiveDeploy::on_tick(const Tick& tick, const TickTiming& timing) {
  recorder_.on_tick(tick, timing);
  if (!feed_) return;
  LiveTiming shown{.late_ms = ms(timing.begin_us - timing.due_us),
                   .tick_ms = ms(timing.end_us - timing.begin_us),
                   .latency_ms = {},
                   .camera_age_ms = age_ms(timing.end_us, robot_.events().heard_us()),
                   .joints_age_ms = {},
                   .skipped_ticks = skipped_ticks_ += timing.missed,
                   .dropped_events = timing.traffic.dropped,
                   .guarded = timing.guarded};
  if (tick.head) shown.joints_age_ms = age_ms(timing.end_us, tick.head->t_us);
  if (timing.latency_us) shown.latency_ms = ms(*timing.latency_us);
  feed_->set_timing(shown);
  feed_->on_tick(tick);
}

void LiveDeploy::on_change(const DeployChange& change) {
  recorder_.on_change(change);
  if (!feed_) return;
  const bool fault = change.stop && is_fault(change.stop->cause);
  feed_->set_state(name_of(change.state), fault);
  std::string line(name_of(change.state));
  if (change.stop) line += ": " + change.stop->description();
  if (!change.rejected.empty()) line = "not activated: " + change.rejected;
  if (!change.warning.empty()) line += "; warning: " + change.warning;
  feed_->add_line(change.t_us, line);
}

void LiveDeploy::on_news(std::int64_t t_us, const std::string& line) {
  recorder_.on_news(t_us, line);
  if (feed_) feed_->add_line(t_us, line);
}

}  // namespace saccade
