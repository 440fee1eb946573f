#include "robot/sender_clock.h"

#include <algorithm>

#include "core/error.h"

namespace saccade {

std::int64_t SenderClock::to_local(std::int64_t sent_us, std::int64_t arrival_us) {
  const std::int64_t delay_us = arrival_us - sent_us;
  const std::int64_t bucket = arrival_us / bucket_us;
  const auto place = [&](std::int64_t number) {
    return static_cast<std::size_t>(number) % delays_us_.size();
  };
  const std::int64_t excess_us = started_ ? delay_us - least_delay_us() : 0;
  if (!started_ || excess_us > jump_us || excess_us < -jump_us) {
    delays_us_.fill(delay_us);
    bucket_ = bucket;
    started_ = true;
  }
  const auto count = static_cast<std::int64_t>(delays_us_.size());
  for (std::int64_t number = std::max(bucket_ + 1, bucket - count + 1); number <= bucket; ++number) {
    delays_us_[place(number)] = delay_us;
  }
  bucket_ = std::max(bucket_, bucket);
  std::int64_t& least_us = delays_us_[place(bucket_)];
  least_us = std::min(least_us, delay_us);
  return sent_us + least_delay_us();
}

std::int64_t SenderClock::least_delay_us() const {
  return *std::min_element(delays_us_.begin(), delays_us_.end());
}

StampCounter::StampCounter(int bits) : range_(std::int64_t{1} << bits) {
  SACCADE_CHECK(bits >= 1 && bits <= 32);
}

std::int64_t StampCounter::begin(std::uint32_t stamp, std::int64_t elapsed_ticks) {
  const std::int64_t value = stamp & (range_ - 1);
  if (!started_) {
    started_ = true;
    return last_ = value;
  }
  const std::int64_t expected = last_ + elapsed_ticks;
  std::int64_t step = (value - expected) % range_;
  if (step < -range_ / 2) step += range_;
  if (step >= range_ / 2) step -= range_;
  return last_ = expected + step;
}

}  // namespace saccade
