// What a millisecond costs a detector, by the rate of events (ball_in_clutter), and in recordings where they are there.
// Counters: events that one core could take per second; the share of one core at the events' own rate (busy); time of a
// millisecond, median, 99 % and longest, up to the estimate (before_*) and with the work after it (whole_*).
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <vector>

#include "core/detectors/built_in_detectors.h"
#include "head/icub_cameras.h"
#include "recording/event_file.h"
#include "tests/bench/ball_in_clutter.h"

namespace saccade {
namespace {

using SteadyClock = std::chrono::steady_clock;

double percentile(std::vector<double>& values, double share) {
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

void measure(benchmark::State& bench, const char* preset, const Camera& camera,
             const std::vector<Event>& events) {
  const auto micros = [](SteadyClock::duration d) {
    return std::chrono::duration<double, std::micro>(d).count();
  };
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

BENCHMARK_CAPTURE(rate, best, "best")
    ->UseManualTime()
    ->Iterations(1)
    ->Arg(100)
    ->Arg(1000)
    ->Arg(3000)
    ->Arg(10000);
BENCHMARK_CAPTURE(rate, paper_directed, "paper_directed")
    ->UseManualTime()
    ->Iterations(1)
    ->Arg(100)
    ->Arg(3000);
BENCHMARK_CAPTURE(recording, em_lab, "best", "stream_em_lab.aedat4")->UseManualTime()->Iterations(1);
BENCHMARK_CAPTURE(recording, hm_labtex, "best", "stream_hm_labtex.aedat4")->UseManualTime()->Iterations(1);
BENCHMARK_CAPTURE(recording, looming, "best", "ball_looming_dvs128_aedat2.aedat")
    ->UseManualTime()
    ->Iterations(1);

}  // namespace
}  // namespace saccade
