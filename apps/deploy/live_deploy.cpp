#include "apps/deploy/live_deploy.h"

#include "apps/live/live_message.h"

namespace saccade {
namespace {

double ms(std::int64_t us) { return 1e-3 * static_cast<double>(us); }

}  // namespace

LiveDeploy::LiveDeploy(DeployObserver& recorder, const std::optional<LiveAddress>& address,
                       OperatorRequests& requests, LiveRun run, const Loop& loop)
    : recorder_(recorder) {
  if (!address) return;
  run.can_stop = true;
  server_.emplace(
      LiveServer::Config{.address = *address, .page = live_page(), .stop = [&requests] { requests.stop(); }});
  feed_.emplace(*server_, std::move(run), loop);
}

void LiveDeploy::on_tick(const Tick& tick, const TickTiming& timing) {
  recorder_.on_tick(tick, timing);
  if (!feed_) return;
  LiveTiming shown{.late_ms = ms(timing.begin_us - timing.due_us),
                   .tick_ms = ms(timing.end_us - timing.begin_us),
                   .latency_ms = {}};
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
