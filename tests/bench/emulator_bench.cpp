#include <benchmark/benchmark.h>

#include <cmath>
#include <vector>

#include "core/random.h"
#include "emulator/event_emulator.h"

namespace saccade {
namespace {

/// A smoothed random texture of 4 px grain and contrast 1:20 that moves 0.4 px per image, back and forth.
std::vector<std::vector<float>> moving_texture(ImageSize size) {
  constexpr int images = 64;
  const RandomStream random(1, "bench");
  std::vector<std::vector<float>> sequence;
  for (int k = 0; k < images; ++k) {
    std::vector<float> image;
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) {
        const double u = (x + 0.4 * k) / 4.0;
        const double v = (y + 0.2 * k) / 4.0;
        const double fu = u - std::floor(u);
        const double fv = v - std::floor(v);
        const auto at = [&](int i, int j) {
          return random.uniform(static_cast<std::uint64_t>(u) + static_cast<std::uint64_t>(i),
                                static_cast<std::uint64_t>(v) + static_cast<std::uint64_t>(j));
        };
        const double value =
            (1 - fv) * ((1 - fu) * at(0, 0) + fu * at(1, 0)) + fv * ((1 - fu) * at(0, 1) + fu * at(1, 1));
        image.push_back(static_cast<float>(255.0 * std::pow(20.0, value - 1.0)));
      }
    }
    sequence.push_back(std::move(image));
  }
  return sequence;
}

/// Images per second, one thread, and how many events they make; image generation excluded.
void process_images(benchmark::State& state, const EmulatorConfig& config) {
  const ImageSize size{static_cast<int>(state.range(0)), static_cast<int>(state.range(1))};
  const auto sequence = moving_texture(size);
  EventEmulator emulator(config, size, 1);
  std::vector<Event> events;
  std::size_t k = 0;
  bool forward = true;
  std::int64_t t_us = 0;
  emulator.process_image(sequence[0], t_us, events);
  for (auto _ : state) {
    forward = k == 0 || (forward && k + 1 < sequence.size());
    k = forward ? k + 1 : k - 1;
    t_us += 1000;
    events.clear();
    emulator.process_image(sequence[k], t_us, events);
    benchmark::DoNotOptimize(events.data());
  }
  state.SetItemsProcessed(state.iterations());
  state.counters["events_per_image"] =
      static_cast<double>(emulator.event_count()) / static_cast<double>(state.iterations());
}

void BM_Ideal(benchmark::State& state) { process_images(state, emulator_preset("ideal")); }
void BM_Dvs128(benchmark::State& state) { process_images(state, emulator_preset("dvs128")); }
BENCHMARK(BM_Ideal)->ArgNames({"width", "height"})->Args({128, 128})->Args({346, 260});
BENCHMARK(BM_Dvs128)->ArgNames({"width", "height"})->Args({128, 128})->Args({346, 260});

}  // namespace
}  // namespace saccade
