#include "apps/deploy/shared_head.h"

#include <bit>
#include <cmath>

namespace saccade {

SharedHead::SharedHead(const std::string& name) : shared_("practice-" + name, sizeof(Memory)) {}

HeadJointVector SharedHead::Motion::position_rad(std::int64_t now_ns) const {
  const double dt_s = 1e-9 * static_cast<double>(std::max<std::int64_t>(0, now_ns - begin_ns));
  return reference_rad + (from_rad - reference_rad) * std::exp(-dt_s / lag_s);
}

/// The newest entry of the newest number that is whole.
SharedHead::Motion SharedHead::newest() const {
  Motion found;
  std::uint64_t found_count = 0;
  for (const Entry& entry : memory().ring) {
    const std::uint64_t count = entry.count.load(std::memory_order_acquire);
    if (count == 0) continue;
    std::array<std::uint64_t, words> word{};
    for (std::size_t i = 0; i < words; ++i) word[i] = entry.word[i].load(std::memory_order_relaxed);
    std::atomic_thread_fence(std::memory_order_acquire);
    if (entry.count.load(std::memory_order_relaxed) != count) continue;
    if (word[0] < found.number || (word[0] == found.number && count <= found_count)) continue;
    found_count = count;
    found.number = word[0];
    found.begin_ns = static_cast<std::int64_t>(word[1]);
    found.follows = word[2] != 0;
    for (std::size_t j = 0; j < gaze_slots; ++j) {
      found.from_rad[static_cast<Eigen::Index>(j)] = std::bit_cast<double>(word[3 + j]);
      found.reference_rad[static_cast<Eigen::Index>(j)] = std::bit_cast<double>(word[3 + gaze_slots + j]);
    }
  }
  return found;
}

void SharedHead::publish(const Motion& motion) {
  const std::uint64_t place = memory().next.fetch_add(1);
  Entry& entry = memory().ring[place % memory().ring.size()];
  entry.count.store(0, std::memory_order_relaxed);
  std::atomic_thread_fence(std::memory_order_release);
  const auto set = [&](std::size_t i, std::uint64_t value) {
    entry.word[i].store(value, std::memory_order_relaxed);
  };
  set(0, motion.number);
  set(1, static_cast<std::uint64_t>(motion.begin_ns));
  set(2, motion.follows ? 1 : 0);
  for (std::size_t j = 0; j < gaze_slots; ++j) {
    set(3 + j, std::bit_cast<std::uint64_t>(motion.from_rad[static_cast<Eigen::Index>(j)]));
    set(3 + gaze_slots + j, std::bit_cast<std::uint64_t>(motion.reference_rad[static_cast<Eigen::Index>(j)]));
  }
  entry.count.store(place + 1, std::memory_order_release);
}

HeadState SharedHead::state(std::int64_t now_ns) const {
  const Motion motion = newest();
  HeadState state;
  state.t_us = now_ns / 1000;
  const HeadJointVector position_rad = motion.position_rad(now_ns);
  state.position_rad.tail<gaze_slots>() = position_rad;
  state.velocity_rad_s.tail<gaze_slots>() = (motion.reference_rad - position_rad) / lag_s;
  return state;
}

bool SharedHead::follows() const {
  const Motion motion = newest();
  return motion.follows && motion.number == memory().number;
}

std::uint64_t SharedHead::begin(bool follows) {
  const std::uint64_t number = memory().number.fetch_add(1) + 1;
  const std::int64_t now_ns = machine_ns();
  const HeadJointVector position_rad = newest().position_rad(now_ns);
  publish({number, now_ns, follows, position_rad, position_rad});
  return number;
}

std::uint64_t SharedHead::take() { return begin(true); }

void SharedHead::hold() {
  begin(false);
  memory().held_ns = machine_ns();
}

bool SharedHead::command(std::uint64_t number, const HeadJointVector& reference_rad) {
  const Motion before = newest();
  if (!before.follows || before.number != number || memory().number != number) return false;
  const std::int64_t now_ns = machine_ns();
  publish({number, now_ns, true, before.position_rad(now_ns), reference_rad});
  if (memory().number != number) return false;  // stopped meanwhile: the entry does not count
  memory().commanded_ns = now_ns;
  return true;
}

}  // namespace saccade
