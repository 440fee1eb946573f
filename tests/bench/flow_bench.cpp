#include <benchmark/benchmark.h>

#include "core/plane_fit_flow.h"
#include "tests/core/reference_flow.h"
#include "tests/core/streams.h"

namespace saccade {
namespace {

constexpr ImageSize image{128, 128};

/// Flow of every event of a stream, over and over; time goes on from pass to pass.
template <class Flow>
void add_and_fit(benchmark::State& state, Flow& flow, const std::vector<Event>& events) {
  const std::int64_t pass_us = events.back().t_us + 1;
  std::int64_t events_done = 0;
  std::size_t i = 0;
  std::int64_t t0_us = 0;
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
}

void BM_PlaneFitFlow(benchmark::State& state) {
  PlaneFitFlowConfig config;
  config.half_width_px = state.range(0);
  PlaneFitFlow flow(config, image);
  add_and_fit(state, flow, streams::cluttered(image, 60'000, 0.3, 1));
}
BENCHMARK(BM_PlaneFitFlow)->ArgName("half_width")->Arg(1)->Arg(2)->Arg(3)->Arg(5);

void BM_ReferenceFlow(benchmark::State& state) {
  ReferenceFlow flow({});
  add_and_fit(state, flow, streams::cluttered(image, 60'000, 0.3, 1));
}
BENCHMARK(BM_ReferenceFlow);

}  // namespace
}  // namespace saccade
