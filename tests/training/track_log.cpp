// Replays a world's events through `best` and writes its followed circles, the steps of their networks and every n-th polar patch,
// without ground truth.
// training/tracks.py calls it and has the layout of input and output.
#include <algorithm>
#include <array>
#include <cmath>
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
  std::uint64_t every_patch = 0;                      // 0: none
  std::vector<std::array<double, 3>> rotation_rad_s;  // of the camera, its own frame; each ms
  std::vector<Event> events;
};

bool read_values(void* to, std::size_t bytes) {
  return static_cast<bool>(std::cin.read(static_cast<char*>(to), static_cast<std::streamsize>(bytes)));
}

bool read_replay(Replay& replay) {
  Camera& c = replay.camera;
  std::size_t ticks = 0, events = 0;
  std::cin >> c.size.width >> c.size.height >> c.fx_px >> c.fy_px >> c.cx_px >> c.cy_px >> c.k1 >> c.k2 >>
      c.p1 >> c.p2 >> replay.config.radius_px[0] >> replay.config.radius_px[1] >> replay.joints >>
      replay.every_patch >> ticks >> events;
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

/// A row of each followed circle every 2 ms, of each step of its network, and of each patch, with the densities of its events
/// and the share inside the image in steps of .01, at most 2.55.
struct Log {
  std::vector<float> circles, steps, patches;
  std::vector<std::uint8_t> densities;
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

void add_patch(const PolarPatch& patch, const BallTracker::JudgedPatch& of, Log& log) {
  constexpr std::size_t of_motion = PolarPatch::event_channels + 1, quarter = PolarPatch::directions / 4;
  const auto at = [&](std::size_t direction, std::size_t channel) {
    return patch.values[direction * PolarPatch::rings * PolarPatch::channels + channel];
  };
  append(log.patches, std::array{static_cast<float>(static_cast<double>(of.t_us) * 1e-3),
                                 static_cast<float>(of.circle.x_px), static_cast<float>(of.circle.y_px),
                                 static_cast<float>(of.circle.r_px), at(0, of_motion), at(quarter, of_motion),
                                 at(0, of_motion + 1), at(quarter, of_motion + 1)});
  append(log.patches, patch.about);
  for (std::size_t i = 0; i < patch.values.size(); ++i) {
    if (i % PolarPatch::channels >= of_motion) continue;
    log.densities.push_back(static_cast<std::uint8_t>(std::lround(std::min(patch.values[i], 2.55F) * 100)));
  }
}

/// Number of values, then these.
template <class Value>
void write(const std::vector<Value>& values) {
  const std::uint64_t count = values.size();
  std::cout.write(reinterpret_cast<const char*>(&count), sizeof count);
  std::cout.write(reinterpret_cast<const char*>(values.data()),
                  static_cast<std::streamsize>(count * sizeof(Value)));
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
  TimeSurface surface(replay.camera.size);
  std::uint64_t patches = 0;
  std::size_t next = 0;
  for (std::size_t k = 0; k < replay.rotation_rad_s.size(); ++k) {
    const auto tick = static_cast<std::int64_t>(k) + 1;
    const std::size_t first = next;
    while (next < replay.events.size() && replay.events[next].t_us <= tick * 1000)
      surface.add(replay.events[next++]);
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
    tracker.work_ahead();
    for (const BallTracker::JudgedPatch& p : tracker.judged_patches()) {
      if (replay.every_patch == 0 || ++patches % replay.every_patch != 0) continue;
      add_patch(polar_patch(surface, p.circle, p.motion, p.t_us), p, log);
    }
  }
  write(log.circles);
  write(log.steps);
  write(log.patches);
  write(log.densities);
  return std::cout.flush() ? 0 : 1;
}

}  // namespace
}  // namespace saccade

int main() { return saccade::run(); }
