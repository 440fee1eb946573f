// Replays a world's events through `best` and writes its followed circles and the steps of their networks, without ground truth.
// training/tracks.py calls it and has the layout of input and output.
#include <array>
#include <cstdint>
#include <cstring>
#include <iostream>
#include <map>
#include <span>
#include <vector>

#include "core/tracker/ball_tracker.h"

namespace saccade {
namespace {

struct Replay {
  Camera camera;
  BallTrackerConfig config;
  bool joints = true;                                 // whether the rotation is known
  std::vector<std::array<double, 3>> rotation_rad_s;  // of the camera, its own frame; each ms
  std::vector<Event> events;
};

bool read_values(void* to, std::size_t bytes) {
  return static_cast<bool>(std::cin.read(static_cast<char*>(to), static_cast<std::streamsize>(bytes)));
}

bool read_replay(Replay& replay) {
  Camera& c = replay.camera;
  std::size_t ticks = 0, events = 0;
  std::cin >> c.size.width >> c.size.height >> c.fx_px >> c.fy_px >> c.cx_px >> c.cy_px >> c.k1 >>
      replay.config.radius_px[0] >> replay.config.radius_px[1] >> replay.joints >> ticks >> events;
  if (!std::cin || std::cin.get() != '\n') return false;
  replay.rotation_rad_s.resize(ticks);
  if (!read_values(replay.rotation_rad_s.data(), ticks * sizeof(replay.rotation_rad_s[0]))) return false;
  std::array<char, 13> record;
  for (std::size_t i = 0; i < events; ++i) {
    Event e;
    if (!read_values(record.data(), record.size())) return false;
    std::memcpy(&e.t_us, record.data(), 8);
    std::memcpy(&e.x, record.data() + 8, 2);
    std::memcpy(&e.y, record.data() + 10, 2);
    e.on = record[12] != 0;
    replay.events.push_back(e);
  }
  return true;
}

template <class Array>
void append(std::vector<float>& to, const Array& values) {
  to.insert(to.end(), values.begin(), values.end());
}

/// A row of each followed circle every 2 ms, and of each step of its network.
struct Log {
  std::vector<float> circles, steps;
};

void add_track(std::int64_t tick, const BallTracker::Track& t, bool stepped, Log& log) {
  if (stepped) {
    append(log.steps, std::array{static_cast<float>(tick), static_cast<float>(t.number)});
    append(log.steps, t.inputs);
  }
  if (tick % 2 != 0) return;
  append(log.circles, std::array{
                          static_cast<float>(tick),
                          static_cast<float>(t.number),
                          static_cast<float>(t.circle.x_px),
                          static_cast<float>(t.circle.y_px),
                          static_cast<float>(t.circle.r_px),
                          static_cast<float>(t.image_px_s.x()),
                          static_cast<float>(t.image_px_s.y()),
                          static_cast<float>(t.existence.probability),
                          static_cast<float>(t.existence.leaves_per_s),
                          static_cast<float>(t.moved_most_share),
                          static_cast<float>(static_cast<double>(t.silent_us) * 1e-6),
                      });
}

/// Number of values, then these.
void write(const std::vector<float>& values) {
  const std::uint64_t count = values.size();
  std::cout.write(reinterpret_cast<const char*>(&count), sizeof count);
  std::cout.write(reinterpret_cast<const char*>(values.data()),
                  static_cast<std::streamsize>(count * sizeof(float)));
}

int run() {
  Replay replay;
  if (!read_replay(replay)) {
    std::cerr << "track_log: the input is cut off or has another layout than training/tracks.py writes\n";
    return 1;
  }
  BallTracker tracker(replay.config, replay.camera);
  Log log;
  std::map<std::uint64_t, std::uint64_t> steps;  // so far, of each circle
  std::size_t next = 0;
  for (std::size_t k = 0; k < replay.rotation_rad_s.size(); ++k) {
    const auto tick = static_cast<std::int64_t>(k) + 1;
    const std::size_t first = next;
    while (next < replay.events.size() && replay.events[next].t_us <= tick * 1000) ++next;
    CameraMotion motion;
    motion.angular_velocity_rad_s = Eigen::Vector3d(replay.rotation_rad_s[k].data());
    const CameraMotion* const known = replay.joints ? &motion : nullptr;
    tracker.process(std::span(replay.events).subspan(first, next - first), known);
    tracker.advance_to(tick * 1000, known);
    std::array<BallTracker::Track, BallTracker::most_tracks> tracks;
    const std::size_t count = tracker.tracks(tracks);
    for (const BallTracker::Track& t : std::span(tracks).first(count)) {
      std::uint64_t& so_far = steps[t.number];
      add_track(tick, t, t.steps != so_far, log);
      so_far = t.steps;
    }
  }
  write(log.circles);
  write(log.steps);
  return std::cout.flush() ? 0 : 1;
}

}  // namespace
}  // namespace saccade

int main() { return saccade::run(); }
