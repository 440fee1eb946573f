// What a millisecond costs a detector with 128 x 128 pixels, by the rate of events: six of ten events lie on the outline of
// a ball that moves in the image, the others anywhere; and recordings at their own rate where they are there. Counters:
// events that one core could take per second; 50 %, 99 % and all of the milliseconds up to the estimate (before_*) and with
// what follows it (whole_*).
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <vector>

#include "core/detector_registry.h"
#include "core/random.h"
#include "head/icub_cameras.h"
#include "recording/event_file.h"

namespace saccade {
namespace {

using SteadyClock = std::chrono::steady_clock;

std::vector<Event> ball_in_clutter(std::int64_t events_per_ms, std::int64_t duration_ms) {
  const RandomStream random(1, "detector_bench");
  std::vector<Event> events;
  const std::int64_t count = events_per_ms * duration_ms;
  events.reserve(static_cast<std::size_t>(count));
  for (std::int64_t i = 0; i < count; ++i) {
    const auto k = static_cast<std::uint64_t>(i);
    const std::int64_t t_us = i * 1000 / events_per_ms;
    const double turn = 2.0 * std::numbers::pi * 1e-6 * static_cast<double>(t_us);
    double x = random.uniform(0.0, 127.0, 0, k);
    double y = random.uniform(0.0, 127.0, 1, k);
    if (i % 10 < 6) {
      const double around = random.uniform(0.0, 2.0 * std::numbers::pi, 2, k);
      x = 64.0 + 30.0 * std::cos(turn) + 11.0 * std::cos(around);
      y = 64.0 + 30.0 * std::sin(turn) + 11.0 * std::sin(around);
    }
    events.push_back({t_us + 1, static_cast<std::uint16_t>(std::lround(x)),
                      static_cast<std::uint16_t>(std::lround(y)), i % 2 == 0, 0});
  }
  return events;
}

double percentile(std::vector<double>& values, double share) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

void measure(benchmark::State& bench, const char* preset, const Camera& camera, const std::vector<Event>& events) {
  const auto micros = [](SteadyClock::duration d) { return std::chrono::duration<double, std::micro>(d).count(); };
  std::vector<double> before_us, whole_us;
  double total_s = 0.0;
  for (auto _ : bench) {
    const auto detector = make_detector(built_in_detectors().config(preset), camera);
    std::size_t next = 0;
    double run_s = 0.0;
    const std::int64_t first_us = events.front().t_us / 1000 * 1000;
    for (std::int64_t now_us = first_us; next < events.size(); now_us += 1000) {
      std::size_t end = next;
      while (end < events.size() && events[end].t_us <= now_us) ++end;
      const auto begin = SteadyClock::now();
      detector->process(std::span(events).subspan(next, end - next), nullptr);
      detector->advance_to(now_us, nullptr);
      benchmark::DoNotOptimize(detector->estimate());
      const auto estimated = SteadyClock::now();
      detector->work_ahead();
      const auto done = SteadyClock::now();
      before_us.push_back(micros(estimated - begin));
      whole_us.push_back(micros(done - begin));
      run_s += micros(done - begin) * 1e-6;
      next = end;
    }
    bench.SetIterationTime(run_s);
    total_s += run_s;
  }
  bench.counters["Mevents_per_s"] =
      static_cast<double>(events.size()) * static_cast<double>(bench.iterations()) / total_s * 1e-6;
  bench.counters["busy"] = total_s / (static_cast<double>(whole_us.size()) * 1e-3);
  for (const auto& [name, values] : {std::pair{"before", &before_us}, std::pair{"whole", &whole_us}}) {
    bench.counters[std::string(name) + "_p50_us"] = percentile(*values, 0.5);
    bench.counters[std::string(name) + "_p99_us"] = percentile(*values, 0.99);
    bench.counters[std::string(name) + "_max_us"] = percentile(*values, 1.0);
  }
}

void rate(benchmark::State& bench, const char* preset) {
  measure(bench, preset, icub_left_2016, ball_in_clutter(bench.range(0), 2000));
}

void recording(benchmark::State& bench, const char* preset, const char* name) {
  const std::filesystem::path file = std::filesystem::path(SACCADE_SHARED_DATA) / name;
  if (!std::filesystem::exists(file)) {
    bench.SkipWithError("no such recording");
    return;
  }
  std::vector<Event> events;
  const auto opened = open_event_file(file);
  while (opened->read(events, 1 << 16) > 0) {
  }
  measure(bench, preset, icub_left_2016, events);
}

BENCHMARK_CAPTURE(rate, best, "best")->UseManualTime()->Iterations(1)->Arg(100)->Arg(1000)->Arg(3000)->Arg(10000);
BENCHMARK_CAPTURE(rate, paper_directed, "paper_directed")->UseManualTime()->Iterations(1)->Arg(100)->Arg(3000);
BENCHMARK_CAPTURE(recording, em_lab, "best", "stream_em_lab.aedat4")->UseManualTime()->Iterations(1);
BENCHMARK_CAPTURE(recording, hm_labtex, "best", "stream_hm_labtex.aedat4")->UseManualTime()->Iterations(1);
BENCHMARK_CAPTURE(recording, looming, "best", "ball_looming_dvs128_aedat2.aedat")->UseManualTime()->Iterations(1);

}  // namespace
}  // namespace saccade
