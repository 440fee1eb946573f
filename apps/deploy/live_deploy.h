#pragma once

#include <optional>

#include "apps/deploy/deploy_session.h"
#include "apps/live/live_feed.h"

namespace saccade {

/// The live page of a deployed run beside the recorder, which comes first. The page can stop the head and command nothing else.
class LiveDeploy final : public DeployObserver {
 public:
  /// All outlive it. `server`: null without a page, then it only passes on.
  LiveDeploy(DeployObserver& recorder, LiveServer* server, LiveRun run, const WatchdogConfig& watchdog,
             Robot& robot, const Loop& loop);

  void on_tick(const Tick& tick, const TickTiming& timing) override;
  void on_change(const DeployChange& change) override;
  void on_news(std::int64_t t_us, const std::string& line) override;

 private:
  DeployObserver& recorder_;
  Robot& robot_;
  std::int64_t skipped_ticks_ = 0;
  std::optional<LiveFeed> feed_;
};

}  // namespace saccade
