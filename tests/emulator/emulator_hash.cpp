// Prints a hash of the events and labels of a fixed scene for every preset and for all stages together.
// determinism_test.sh compares the hashes over compilers and optimisation levels.
#include <cstdio>

#include "core/random.h"
#include "emulator/event_emulator.h"

namespace {

using namespace saccade;

/// FNV-1a over the values, not the padding.
class Hash {
 public:
  void add(std::uint64_t value) {
    for (int byte = 0; byte < 8; ++byte) hash_ = (hash_ ^ ((value >> (8 * byte)) & 0xff)) * 0x100000001b3ULL;
  }
  [[nodiscard]] std::uint64_t value() const { return hash_; }

 private:
  std::uint64_t hash_ = 0xcbf29ce484222325ULL;
};

std::uint64_t hash_of(const EmulatorConfig& config) {
  const ImageSize size{64, 48};
  EventEmulator emulator(config, size, 5, 2);
  const RandomStream random(77, "texture");
  std::vector<float> image(static_cast<std::size_t>(size.pixels()));
  std::vector<Event> events;
  std::vector<EventLabel> labels;
  std::int64_t t_us = 0;
  for (int k = 0; k <= 120; ++k) {
    for (std::size_t i = 0; i < image.size(); ++i) {
      // Light of each pixel in straight lines with a corner every 20 images, from exact arithmetic only.
      const std::uint64_t leg = static_cast<std::uint64_t>(k) / 20;
      const double from = random.uniform(i, leg);
      const double to = random.uniform(i, leg + 1);
      image[i] = static_cast<float>(250.0 * (from + (to - from) * (k % 20) / 20.0));
    }
    emulator.process_image(image, t_us, events, &labels);
    t_us += k % 3 == 0 ? 350 : 1700;
  }
  emulator.finish(events, &labels);
  Hash hash;
  for (std::size_t i = 0; i < events.size(); ++i) {
    hash.add(static_cast<std::uint64_t>(events[i].t_us));
    hash.add(events[i].x);
    hash.add(events[i].y);
    hash.add(events[i].on ? 1 : 0);
    hash.add(static_cast<std::uint64_t>(labels[i].cause));
  }
  return hash.value();
}

}  // namespace

int main() {
  for (const std::string& preset : emulator_presets()) {
    std::printf("%s %016llx\n", preset.c_str(),
                static_cast<unsigned long long>(hash_of(emulator_preset(preset))));
  }
  EmulatorConfig everything = emulator_preset("dvs128");
  everything.cutoff_hz = 400.0;
  everything.leak_rate_hz = 5.0;
  everything.shot_noise_rate_hz = 20.0;
  everything.hot_pixel_share = 0.01;
  everything.readout_rate_hz = 400e3;
  everything.readout_queue_events = 500;
  std::printf("everything %016llx\n", static_cast<unsigned long long>(hash_of(everything)));
  everything.leak_light_hz = 4.0;
  everything.leak_light_spread_decades = 0.2;
  everything.leaky_pixel_share = 0.05;
  everything.shot_noise_spread_decades = 0.25;
  everything.shot_noise_on_share = 0.6;
  everything.shot_noise_light = 60.0;
  std::printf("measured_noise %016llx\n", static_cast<unsigned long long>(hash_of(everything)));
}
