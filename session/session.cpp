#include "session/session.h"

#include <string>

#include "core/error.h"
#include "session/interrupt.h"

namespace saccade {

bool Session::tick(std::int64_t t_us) {
  if (!begin_) begin_ = std::chrono::steady_clock::now();
  const PortStatus status = loop_.tick(t_us, observers_);
  if (status == PortStatus::lost) throw RunError("lost the connection to the " + std::string(loop_.lost()));
  return status == PortStatus::ok;
}

void Session::run(std::int64_t tick_us, std::int64_t end_us, std::optional<std::int64_t> grid_us) {
  const std::int64_t start_us = robot_.clock().now_us();
  const std::int64_t past_us = grid_us ? ((start_us - *grid_us) % tick_us + tick_us) % tick_us : 0;
  for (std::int64_t t_us = start_us - past_us + tick_us; t_us <= end_us && !interrupted(); t_us += tick_us) {
    if (!tick(t_us)) return;
  }
}

double Session::wall_s() const {
  if (!begin_) return 0.0;
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - *begin_).count();
}

}  // namespace saccade
