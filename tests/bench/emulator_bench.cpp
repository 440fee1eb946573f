// Images per second of the emulator, one thread, on a moving cluttered texture; image generation excluded. Beside it
// a plain implementation of the same pixel model, to compare with in the same run.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/random.h"
#include "emulator/event_emulator.h"

namespace saccade {
namespace {

using Images = std::vector<std::vector<float>>;

/// Clutter of three grain sizes and a contrast of about 1:5, moving by `step_px` per image.
Images moving_clutter(ImageSize size, double step_px) {
  constexpr int images = 12;  // few enough to stay in a cache, as those of a renderer are
  const RandomStream random(1, "bench");
  const auto grain = [&](double x, double y, double cell, std::uint64_t layer) {
    const double u = x / cell;
    const double v = y / cell;
    const double fu = u - std::floor(u);
    const double fv = v - std::floor(v);
    const auto at = [&](int i, int j) {
      return random.uniform((static_cast<std::uint64_t>(u) + static_cast<std::uint64_t>(i)) * 4 + layer,
                            static_cast<std::uint64_t>(v) + static_cast<std::uint64_t>(j));
    };
    return (1 - fv) * ((1 - fu) * at(0, 0) + fu * at(1, 0)) + fv * ((1 - fu) * at(0, 1) + fu * at(1, 1));
  };
  Images sequence;
  for (int k = 0; k < images; ++k) {
    std::vector<float> image;
    image.reserve(static_cast<std::size_t>(size.pixels()));
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) {
        const double u = x + 0.9 * step_px * k;
        const double v = y + 0.4 * step_px * k;
        const double value = (grain(u, v, 40.0, 0) + grain(u, v, 16.0, 1) + grain(u, v, 6.0, 2)) / 3.0;
        image.push_back(static_cast<float>(25.0 + 205.0 * value));
      }
    }
    sequence.push_back(std::move(image));
  }
  return sequence;
}

/// Plays the images to and fro, 1 ms apart.
class Player {
 public:
  explicit Player(const Images& images) : images_(images) {}
  const std::vector<float>& next() {
    forward_ = k_ == 0 || (forward_ && k_ + 1 < images_.size());
    k_ = forward_ ? k_ + 1 : k_ - 1;
    t_us_ += 1000;
    return images_[k_];
  }
  [[nodiscard]] std::int64_t t_us() const { return t_us_; }

 private:
  const Images& images_;
  std::size_t k_ = 0;
  bool forward_ = true;
  std::int64_t t_us_ = 0;
};

/// ESIM's model with a fixed threshold for every pixel, as one would write it down: the logarithm of every pixel,
/// linear crossing times, a sort.
class PlainEmulator {
 public:
  PlainEmulator(double threshold, double mismatch, ImageSize size) : width_(size.width) {
    const RandomStream random(1, "emulator");
    for (std::size_t i = 0; i < static_cast<std::size_t>(size.pixels()); ++i) {
      on_.push_back(threshold * (1.0 + mismatch * random.normal(i, 0)));
      off_.push_back(threshold * (1.0 + mismatch * random.normal(i, 1)));
    }
  }

  void process_image(const std::vector<float>& luminance, std::int64_t t_us, std::vector<Event>& events) {
    const std::size_t n = luminance.size();
    if (last_.empty()) {
      for (const float value : luminance) last_.push_back(std::log(static_cast<double>(value) + 1e-3));
      reference_ = last_;
      t_us_ = t_us;
      return;
    }
    const auto dt = static_cast<double>(t_us - t_us_);
    const auto first = static_cast<std::ptrdiff_t>(events.size());
    for (std::size_t i = 0; i < n; ++i) {
      const double now = std::log(static_cast<double>(luminance[i]) + 1e-3);
      for (;;) {
        const bool on = now >= reference_[i] + on_[i];
        if (!on && now > reference_[i] - off_[i]) break;
        reference_[i] += on ? on_[i] : -off_[i];
        const double t = (reference_[i] - last_[i]) / (now - last_[i]) * dt;
        events.push_back({t_us_ + static_cast<std::int64_t>(std::ceil(t)),
                          static_cast<std::uint16_t>(static_cast<int>(i) % width_),
                          static_cast<std::uint16_t>(static_cast<int>(i) / width_), on, 0});
      }
      last_[i] = now;
    }
    std::sort(events.begin() + first, events.end(),
              [](const Event& a, const Event& b) { return a.t_us < b.t_us; });
    t_us_ = t_us;
  }

 private:
  int width_;
  std::int64_t t_us_ = 0;
  std::vector<double> on_, off_, last_, reference_;
};

ImageSize size_of(const benchmark::State& state) {
  return {static_cast<int>(state.range(0)), static_cast<int>(state.range(1))};
}

double step_px_of(const benchmark::State& state) { return static_cast<double>(state.range(2)) * 0.01; }

template <class Emulator>
void play(benchmark::State& state, Emulator& emulator, const Images& images) {
  Player player(images);
  std::vector<Event> events;
  emulator.process_image(images[0], 0, events);
  std::int64_t count = 0;
  for (auto _ : state) {
    const std::vector<float>& image = player.next();
    events.clear();
    emulator.process_image(image, player.t_us(), events);
    count += static_cast<std::int64_t>(events.size());
    benchmark::DoNotOptimize(events.data());
  }
  state.SetItemsProcessed(state.iterations());
  state.counters["events_per_image"] = static_cast<double>(count) / static_cast<double>(state.iterations());
}

void BM_Plain(benchmark::State& state) {
  PlainEmulator emulator(0.2, 0.021, size_of(state));
  play(state, emulator, moving_clutter(size_of(state), step_px_of(state)));
}

/// Mismatch on, noise and everything else off: the model of BM_Plain.
void BM_Clean(benchmark::State& state) {
  EmulatorConfig config = emulator_preset("ideal");
  config.threshold_mismatch = 0.021;
  EventEmulator emulator(config, size_of(state), 1);
  play(state, emulator, moving_clutter(size_of(state), step_px_of(state)));
}

void BM_EveryStage(benchmark::State& state) {
  EmulatorConfig config = emulator_preset("dvs128");
  config.hot_pixel_share = 0.001;
  config.readout_rate_hz = 20e6;  // a bus that takes what these scenes make
  EventEmulator emulator(config, size_of(state), 1);
  play(state, emulator, moving_clutter(size_of(state), step_px_of(state)));
}

void scenes(benchmark::internal::Benchmark* b) {
  b->ArgNames({"width", "height", "step_percent_px"})->Unit(benchmark::kMicrosecond);
  for (const ImageSize size : {ImageSize{128, 128}, {346, 260}, {640, 480}, {1280, 720}}) {
    for (const int step : {0, 30, 100}) b->Args({size.width, size.height, step});
  }
}
BENCHMARK(BM_Plain)->Apply(scenes);
BENCHMARK(BM_Clean)->Apply(scenes);
BENCHMARK(BM_EveryStage)->Apply(scenes);

}  // namespace
}  // namespace saccade
