#include <benchmark/benchmark.h>

#include <ctime>

#include "core/flow/plane_fit_flow.h"
#include "tests/core/reference_flow.h"
#include "tests/core/streams.h"

namespace saccade {
namespace {

constexpr ImageSize image{128, 128};

/// Adds every event of a stream and fits there, over and over; time goes on from pass to pass. Processor time
/// per event.
template <class Flow>
double add_and_fit(benchmark::State& state, Flow& flow, const std::vector<Event>& events) {
  const std::int64_t pass_us = events.back().t_us + 1;
  std::int64_t events_done = 0;
  std::size_t i = 0;
  std::int64_t t0_us = 0;
  const std::clock_t start = std::clock();
  for (auto _ : state) {
    Event e = events[i];
    e.t_us += t0_us;
    flow.add(e);
    benchmark::DoNotOptimize(flow.at(e));
    ++events_done;
    if (++i == events.size()) {
      i = 0;
      t0_us += pass_us;
    }
  }
  state.SetItemsProcessed(events_done);
  return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC / static_cast<double>(events_done);
}

std::vector<Event> stream() { return streams::cluttered(image, 60'000, 0.3, 1); }

double& reference_s_per_event() {
  static double s = 0.0;
  return s;
}

void BM_ReferenceFlow(benchmark::State& state) {
  PlaneFitFlowConfig config;
  config.half_width_px = state.range(0);
  ReferenceFlow flow(config);
  reference_s_per_event() = add_and_fit(state, flow, stream());
}

void BM_PlaneFitFlow(benchmark::State& state) {
  PlaneFitFlowConfig config;
  config.half_width_px = state.range(0);
  PlaneFitFlow flow(config, image);
  const double s_per_event = add_and_fit(state, flow, stream());
  if (state.range(0) == 2 && reference_s_per_event() > 0.0)
    state.counters["x_reference"] = reference_s_per_event() / s_per_event;
}
BENCHMARK(BM_ReferenceFlow)->ArgName("half_width")->Arg(2);
BENCHMARK(BM_PlaneFitFlow)->ArgName("half_width")->Arg(2)->Arg(1)->Arg(3)->Arg(5);

}  // namespace
}  // namespace saccade
