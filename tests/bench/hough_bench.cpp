#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <map>
#include <numbers>
#include <optional>

#include "core/hough/hough_detector.h"
#include "tests/core/reference_hough.h"
#include "tests/core/streams.h"

namespace saccade {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::int64_t window_events = 1500;

/// Processor time of this program: what else the machine does counts less than on a clock.
double cpu_s() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

HoughDetectorConfig paper(bool directed) {
  HoughDetectorConfig config;
  config.directed = directed;
  config.window.events = window_events;
  return config;
}

std::vector<Event> stream(ImageSize size, std::size_t count) {
  return streams::cluttered(size, count, 0.3, 1);
}

/// Seconds per event of the plain reference, flow left out, asked after each event; measured once per program
/// on few events.
double reference_s_per_event(bool directed, ImageSize size) {
  static std::map<std::pair<bool, int>, double> known;
  double& s = known[{directed, size.pixels()}];
  if (s > 0.0) return s;
  const HoughDetectorConfig config = paper(directed);
  ReferenceHough hough(size, 10, 35, 10,
                       directed ? std::optional(config.arc_deg * std::numbers::pi / 180) : std::nullopt);
  const std::vector<Event> events = stream(size, 100);  // the window of 10 is full after a tenth: in and out
  const double start = cpu_s();
  for (const Event& e : events) {
    hough.push(e.x, e.y, 0.5);
    benchmark::DoNotOptimize(hough.peak());
  }
  return s = (cpu_s() - start) / static_cast<double>(events.size());
}

/// Passes a stream over and over, `batch` events at a time, and asks after each batch; us_per_query is the
/// whole cost of a batch, its flow, its votes and the answer.
void process_and_ask(benchmark::State& state, const HoughDetectorConfig& config, ImageSize size,
                     std::size_t batch) {
  HoughDetector detector(config, size);
  std::vector<Event> events = stream(size, 120'000 / batch * batch);
  const std::int64_t pass_us = events.back().t_us + 1;
  std::int64_t done = 0;
  std::size_t i = 0;
  const auto next_batch = [&] {
    detector.process(std::span(events).subspan(i, batch), nullptr);
    benchmark::DoNotOptimize(detector.estimate());
    done += static_cast<std::int64_t>(batch);
    i += batch;
    if (i < events.size()) return;
    i = 0;
    for (Event& e : events) e.t_us += pass_us;
  };
  for (std::size_t k = 0; k * batch < 3000; ++k) next_batch();  // a full window
  done = 0;
  const double start = cpu_s();
  for (auto _ : state) next_batch();
  const double s_per_event = (cpu_s() - start) / static_cast<double>(done);
  state.SetItemsProcessed(done);
  state.counters["us_per_query"] = s_per_event * static_cast<double>(batch) * 1e6;
  if (size.pixels() <= 128 * 128 && config.radius_px == std::array<double, 2>{10, 35}) {
    state.counters["x_reference"] = reference_s_per_event(config.directed, size) / s_per_event;
  }
}

constexpr ImageSize dvs128{128, 128};

void BM_Directed(benchmark::State& state) {
  process_and_ask(state, paper(true), dvs128, static_cast<std::size_t>(state.range(0)));
}
void BM_Full(benchmark::State& state) {
  process_and_ask(state, paper(false), dvs128, static_cast<std::size_t>(state.range(0)));
}
// One event per query is event by event; 10,000 per query is 10 Mevent/s asked every millisecond.
BENCHMARK(BM_Directed)->ArgName("events_per_query")->Arg(1)->Arg(10)->Arg(100)->Arg(1000)->Arg(10'000);
BENCHMARK(BM_Full)->ArgName("events_per_query")->Arg(1)->Arg(10)->Arg(100)->Arg(1000)->Arg(10'000);

void BM_DirectedRadii(benchmark::State& state) {
  HoughDetectorConfig config = paper(true);
  config.radius_px = {10.0, static_cast<double>(9 + state.range(0))};
  process_and_ask(state, config, dvs128, 1);
}
BENCHMARK(BM_DirectedRadii)->ArgName("radii")->Arg(1)->Arg(6)->Arg(13)->Arg(26)->Arg(52);

void BM_DirectedWindow(benchmark::State& state) {
  HoughDetectorConfig config = paper(true);
  config.window.events = state.range(0);
  process_and_ask(state, config, dvs128, 1);
}
BENCHMARK(BM_DirectedWindow)->ArgName("window")->Arg(500)->Arg(1500)->Arg(5000);

void BM_DirectedImage(benchmark::State& state) {
  process_and_ask(state, paper(true), {static_cast<int>(state.range(0)), static_cast<int>(state.range(1))},
                  1);
}
BENCHMARK(BM_DirectedImage)
    ->ArgNames({"width", "height"})
    ->Args({128, 128})
    ->Args({304, 240})
    ->Args({640, 480});

/// 1 Mevent/s, asked every millisecond.
void BM_FullImage(benchmark::State& state) {
  HoughDetectorConfig config = paper(false);
  config.radius_px = {5.0, 60.0};
  process_and_ask(state, config, {static_cast<int>(state.range(0)), static_cast<int>(state.range(1))}, 1000);
}
BENCHMARK(BM_FullImage)->ArgNames({"width", "height"})->Args({128, 128})->Args({346, 260})->Args({640, 480});

/// Time from an event to its estimate, event by event, as percentiles over the stream.
void BM_DirectedLatency(benchmark::State& state) {
  HoughDetector detector(paper(true), dvs128);
  const std::vector<Event> events = stream(dvs128, 120'000);
  std::vector<double> us;
  us.reserve(events.size());
  for (auto _ : state) {
    for (const Event& e : events) {
      const auto start = Clock::now();
      detector.process({&e, 1}, nullptr);
      benchmark::DoNotOptimize(detector.estimate());
      us.push_back(std::chrono::duration<double, std::micro>(Clock::now() - start).count());
    }
  }
  std::sort(us.begin(), us.end());
  state.counters["p50_us"] = us[us.size() / 2];
  state.counters["p99_us"] = us[us.size() * 99 / 100];
}
BENCHMARK(BM_DirectedLatency)->Iterations(1)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace saccade
