#include "evaluation/sensor_fit/pixel_trains.h"

namespace saccade {

void PixelTrains::finish() {
  for (const Added& a : added_) ++begin_[a.pixel + 1];
  for (std::size_t i = 1; i < begin_.size(); ++i) begin_[i] += begin_[i - 1];
  events_.resize(added_.size());
  std::vector<std::size_t> next(begin_.begin(), begin_.end() - 1);
  for (const Added& a : added_) events_[next[a.pixel]++] = a.event;
  added_ = {};
}

PixelTrains PixelTrains::without(std::span<const std::uint8_t> dropped) const {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < pixels(); ++i) kept += dropped[i] == 0 ? 1 : 0;
  PixelTrains some(kept);
  std::size_t number = 0;
  for (std::size_t i = 0; i < pixels(); ++i) {
    if (dropped[i] != 0) continue;
    for (const TrainEvent& event : of(i)) some.add(number, event);
    ++number;
  }
  some.finish();
  return some;
}

PixelTrains PixelTrains::half(bool second) const {
  std::vector<std::uint8_t> dropped(pixels());
  for (std::size_t i = 0; i < pixels(); ++i) dropped[i] = (i % 2 == 1) == second ? 0 : 1;
  return without(dropped);
}

}  // namespace saccade
