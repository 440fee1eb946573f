#include "robot/replay/paced_replay.h"

#include <cmath>
#include <thread>

#include "core/error.h"

namespace saccade {

PacedReplay::PacedReplay(std::string name, std::unique_ptr<EventReader> events,
                         std::optional<RecordedHead> head, double speed)
    : name_(std::move(name)),
      replay_(std::move(events), std::move(head)),
      speed_(speed),
      start_us_(replay_.now_us()) {
  SACCADE_CHECK(speed_ > 0.0);
}

std::vector<StartUpCheck> PacedReplay::check() {
  const ImageSize size = replay_.image_size();
  return {{"recording " + name_, true,
           "images of " + std::to_string(size.width) + " x " + std::to_string(size.height) + " pixels, " +
               (head() != nullptr ? "with joints" : "without joints")}};
}

std::int64_t PacedReplay::now_us() const {
  if (!start_) return start_us_;
  const std::chrono::duration<double, std::micro> passed = std::chrono::steady_clock::now() - *start_;
  return start_us_ + static_cast<std::int64_t>(passed.count() * speed_);
}

PortStatus PacedReplay::wait_until(std::int64_t t_us) {
  if (!start_) start_ = std::chrono::steady_clock::now();
  if (const std::int64_t ahead_us = t_us - start_us_; t_us > now_us()) {
    const std::chrono::duration<double, std::micro> from_start(
        std::ceil(static_cast<double>(ahead_us) / speed_) + 1.0);
    std::this_thread::sleep_until(*start_ + std::chrono::duration_cast<std::chrono::nanoseconds>(from_start));
  }
  return replay_.wait_until(t_us);
}

}  // namespace saccade
