// A bright bar crosses the view of an event camera. Prints what the camera says of it.
#include <saccade/emulator/event_emulator.h>

#include <algorithm>
#include <cinttypes>
#include <cstdio>
#include <vector>

namespace {

constexpr saccade::ImageSize size{128, 128};

/// The bar is 10 pixels wide and moves at 400 pixels per second. A pixel sees the share of it that the bar covers.
void draw_bar(double t_s, std::vector<float>& luminance) {
  const double left = 20.0 + 400.0 * t_s;
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const double covered = std::clamp(std::min(x + 0.5, left + 10.0) - std::max(x - 0.5, left), 0.0, 1.0);
      luminance[static_cast<std::size_t>(y * size.width + x)] = static_cast<float>(40.0 + 160.0 * covered);
    }
  }
}

}  // namespace

int main() {
  constexpr std::uint64_t seed = 1;
  try {
    saccade::EventEmulator camera(saccade::emulator_preset("dvs128"), size, seed);
    std::vector<float> image(static_cast<std::size_t>(size.pixels()));
    std::vector<saccade::Event> events;
    for (int k = 0; k <= 200; ++k) {  // an image per millisecond
      draw_bar(k * 1e-3, image);
      camera.process_image(image, k * 1000, events);
    }
    camera.finish(events);

    std::uint64_t hash = 0xcbf29ce484222325U;  // FNV-1a
    for (const saccade::Event& e : events) {
      for (const std::int64_t value : {e.t_us, std::int64_t{e.x}, std::int64_t{e.y}, std::int64_t{e.on}}) {
        hash = (hash ^ static_cast<std::uint64_t>(value)) * 0x100000001b3U;
      }
    }
    const saccade::EmulatorCounts& counts = camera.counts();
    std::printf("%" PRId64 " events, %" PRId64 " ON, %" PRId64 " OFF\n", counts.events(), counts.on,
                counts.off);
    if (!events.empty()) {
      std::printf("first at %" PRId64 " us, last at %" PRId64 " us\n", events.front().t_us,
                  events.back().t_us);
    }
    std::printf("hash %016" PRIx64 "\n", hash);
  } catch (const saccade::InputError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
  return 0;
}
