// The longest ticks of a deployed loop with the budget of docs/robot.md: DETECTOR KIND TICKS, in virtual time. The work of a
// tick depends on its events alone, so the same call has the same ticks. Prints percentiles and the longest, in us of processor
// time; under
//   valgrind --tool=callgrind --combine-dumps=no --callgrind-out-file=FILE longest_tick DETECTOR KIND TICKS FILE
// in instructions instead, which no other program of the machine changes.
#include <fmt/format.h>
#if __has_include(<valgrind/callgrind.h>)
#include <valgrind/callgrind.h>
#else
#define CALLGRIND_ZERO_STATS
#define CALLGRIND_DUMP_STATS
#endif

#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "apps/deploy/deploy_session.h"
#include "config/robot_file.h"
#include "control/controller_registry.h"
#include "control/gate_registry.h"
#include "core/detectors/built_in_detectors.h"
#include "core/random.h"
#include "head/icub_cameras.h"
#include "robot/fake/fake_robot.h"
#include "tests/control/genova02.h"

namespace saccade {
namespace {

constexpr std::int64_t period_us = 1000;
constexpr std::int64_t pool_ms = 2000;  ///< of events, repeated with later times
constexpr int side_px = 128;

/// Events of each millisecond, times from its begin.
using Pool = std::vector<std::vector<Event>>;

/// `count(ms)` events in each millisecond, at `place(ms, i)`.
template <class Count, class Place>
Pool make_pool(const Count& count, const Place& place) {
  Pool pool(pool_ms);
  for (std::int64_t ms = 0; ms < pool_ms; ++ms) {
    const std::int64_t events = count(ms);
    for (std::int64_t i = 0; i < events; ++i) {
      const auto [x, y] = place(ms, i);
      const auto pixel = [](double at) {
        return static_cast<std::uint16_t>(std::clamp<long>(std::lround(at), 0, side_px - 1));
      };
      pool[static_cast<std::size_t>(ms)].push_back(
          {1 + i * (period_us - 2) / std::max<std::int64_t>(1, events), pixel(x), pixel(y), i % 2 == 0, 0});
    }
  }
  return pool;
}

const RandomStream random_(1, "longest_tick");

double uniform(double from, double to, std::uint64_t what, std::int64_t ms, std::int64_t i) {
  return random_.uniform(from, to, what, static_cast<std::uint64_t>(ms * 20'000 + i));
}

std::pair<double, double> anywhere(std::int64_t ms, std::int64_t i) {
  return {uniform(0, side_px - 1, 0, ms, i), uniform(0, side_px - 1, 1, ms, i)};
}

/// On one of `balls` outlines that go round, each in its own place; radius 4 to 14 px.
std::pair<double, double> on_balls(int balls, std::int64_t ms, std::int64_t i) {
  const auto ball = static_cast<double>(i % balls);
  const double turn = 2.0 * std::numbers::pi * (static_cast<double>(ms) / pool_ms + ball / balls);
  const double around = uniform(0, 2.0 * std::numbers::pi, 2, ms, i);
  const double radius = balls == 1 ? 11.0 : 4.0 + 10.0 * ball / (balls - 1);
  const double orbit = balls == 1 ? 20.0 : 44.0;
  return {64.0 + orbit * std::cos(turn) + radius * std::cos(around),
          64.0 + orbit * std::sin(turn) + radius * std::sin(around)};
}

/// 2000 events are a whole budget, 10,000 more than the bus of the iCub's sensors carries in 1 ms.
const std::map<std::string, Pool (*)()> pools = {
    {"usual",
     [] {
       return make_pool([](auto) { return 100; },
                        [](auto ms, auto i) { return i % 5 < 3 ? on_balls(1, ms, i) : anywhere(ms, i); });
     }},
    {"eight_balls",
     [] { return make_pool([](auto) { return 2000; }, [](auto ms, auto i) { return on_balls(8, ms, i); }); }},
    {"one_spot",
     [] {
       return make_pool([](auto) { return 10'000; },
                        [](auto ms, auto i) {
                          return std::pair{uniform(60, 68, 0, ms, i), uniform(60, 68, 1, ms, i)};
                        });
     }},
    {"everywhere", [] { return make_pool([](auto) { return 10'000; }, anywhere); }},
    {"full_queue",  // silence, then all at once
     [] { return make_pool([](auto ms) { return ms % 20 == 19 ? 20'000 : 0; }, anywhere); }},
};

/// A fake head, and a camera that repeats its pool.
class Overloaded final : public Robot, public EventSource {
 public:
  Overloaded(FakeRobotScript script, Pool pool) : world_(std::move(script)), pool_(std::move(pool)) {}
  Clock& clock() override { return world_; }
  EventSource& events() override { return *this; }
  HeadPort* head() override { return &world_; }
  GazePort* gaze() override { return nullptr; }
  std::vector<StartUpCheck> check() override { return {}; }
  void activate() override {}
  void release() override {}

  [[nodiscard]] ImageSize image_size() const override { return {side_px, side_px}; }
  PortStatus read_until(std::int64_t t_us, std::vector<Event>& events) override {
    events.clear();
    for (; (next_ms_ + 1) * period_us <= t_us; ++next_ms_) {
      const auto& block = pool_[static_cast<std::size_t>(next_ms_ % pool_ms)];
      const std::size_t first = events.size();
      events.insert(events.end(), block.begin(), block.end());
      for (std::size_t i = first; i < events.size(); ++i) events[i].t_us += next_ms_ * period_us;
    }
    return PortStatus::ok;
  }
  [[nodiscard]] std::int64_t heard_us() const override { return world_.now_us(); }
  [[nodiscard]] EventTraffic traffic() const override { return {}; }

 private:
  FakeRobot world_;
  Pool pool_;
  std::int64_t next_ms_ = 0;
};

class Nobody final : public DeployObserver {
 public:
  void on_tick(const Tick& tick, const TickTiming&) override { targets += tick.new_target_m ? 1 : 0; }
  void on_change(const DeployChange& change) override {
    if (change.stop) fmt::print(stderr, "the head was stopped: {}\n", change.stop->description());
  }
  void on_news(std::int64_t, const std::string&) override {}
  std::int64_t targets = 0;
};

/// The instructions since the dump before, from the dump that Callgrind has just written and that is deleted.
double instructions(const std::string& file, std::int64_t number) {
  const std::string path = file + "." + std::to_string(number);
  std::ifstream stream(path);
  double found = -1.0;
  for (std::string line; std::getline(stream, line);)
    if (line.starts_with("totals: ")) found = std::strtod(line.c_str() + 8, nullptr);
  std::filesystem::remove(path);
  return found;
}

/// Processor time of this thread, which other programs do not lengthen by their turns.
double processor_us() {
  timespec time{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return 1e6 * static_cast<double>(time.tv_sec) + 1e-3 * static_cast<double>(time.tv_nsec);
}

int run(const std::string& preset, Pool pool, std::int64_t ticks, const std::string& dumps) {
  FakeRobotScript script;
  script.limits = genova02_limits();
  Overloaded robot(std::move(script), std::move(pool));
  std::vector<LoopDetector> detectors;
  detectors.push_back({preset, make_detector(built_in_detectors().config(preset), icub_left_2016)});
  const auto most_events = static_cast<std::size_t>(RobotFile{}.deploy.max_events_per_tick);
  Loop loop(robot, MountedCamera{icub_left_2016, {}}, std::move(detectors),
            LoopGaze{0, make_gate(built_in_gates().config()), std::nullopt, FollowConfig{.start_s = 0.0}},
            Eye::left, LoopBudget{most_events, 500});
  const GazeControllerConfig config = built_in_controllers().config();
  const auto motion = [&] {
    const JointLimits limits = genova02_limits();
    return LoopMotion{make_gaze_controller(config, limits), JointLimiter(motion_limits(limits, {}))};
  };
  OperatorRequests requests;
  Nobody nobody;
  DeploySession session(robot, loop, motion, requests, nobody, {});
  session.set_ready();
  requests.activate();
  for (int i = 0; i < 20; ++i) session.tick();  // the activation
  std::vector<float> costs;
  costs.reserve(static_cast<std::size_t>(ticks));
  CALLGRIND_DUMP_STATS;
  if (!dumps.empty() && instructions(dumps, 1) < 0.0) {
    fmt::print(stderr, "longest_tick: {}.1: no dump of Callgrind, expected one\n", dumps);
    return 2;
  }
  for (std::int64_t i = 0; i < ticks; ++i) {
    const double begin_us = processor_us();
    if (!dumps.empty()) CALLGRIND_ZERO_STATS;
    session.tick();
    if (!dumps.empty()) {
      CALLGRIND_DUMP_STATS;
      costs.push_back(static_cast<float>(instructions(dumps, i + 2)));
    } else {
      costs.push_back(static_cast<float>(processor_us() - begin_us));
    }
  }
  std::ranges::sort(costs);
  const auto share = [&](double of) {
    return costs[static_cast<std::size_t>(of * static_cast<double>(costs.size() - 1))];
  };
  fmt::print("{:.1f} {:.1f} {:.1f} {:.1f} {:.1f}  {}\n", share(0.5), share(0.99), share(0.9999),
             share(0.999999), costs.back(), nobody.targets);
  return 0;
}

}  // namespace
}  // namespace saccade

int main(int count, char** words) {
  using namespace saccade;
  const auto pool = count > 2 ? pools.find(words[2]) : pools.end();
  if (count < 4 || pool == pools.end()) {
    fmt::print(stderr,
               "usage: longest_tick DETECTOR KIND TICKS [FILE of --callgrind-out-file]\nKIND: one of");
    for (const auto& [name, make] : pools) fmt::print(stderr, " {}", name);
    fmt::print(stderr, "\nprints: median, 99 %, 99.99 %, 99.9999 %, longest; targets\n");
    return 2;
  }
  return run(words[1], pool->second(), std::atoll(words[3]), count > 4 ? words[4] : "");
}
