// Events per second of one core that the readers of binary files give, from the page cache: synthetic streams (edges as
// rows of pixels, among single events of noise), and the real recordings where they are there.
#include <benchmark/benchmark.h>

#include <map>

#include "core/random.h"
#include "recording/event_file.h"
#include "tests/recording/small_files.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

/// Three of four events are of rows: pixels of one time and polarity, from dense to one in eight.
std::vector<Event> edges_and_noise(ImageSize size, std::size_t count) {
  const RandomStream random(7, "recording_bench");
  const auto width = static_cast<std::uint64_t>(size.width);
  std::vector<Event> events;
  std::int64_t t_us = 1'000'000;
  for (std::uint64_t i = 0; events.size() < count; ++i) {
    t_us += static_cast<std::int64_t>(random.bits(0, i) % 2);
    Event event{t_us, static_cast<std::uint16_t>(random.bits(1, i) % width),
                static_cast<std::uint16_t>(random.bits(2, i) % static_cast<std::uint64_t>(size.height)),
                (random.bits(3, i) & 1) != 0, 0};
    const std::uint64_t row = i % 5 == 0 ? 12 : 1;
    const std::uint64_t gaps = 1 + random.bits(4, i) % 8;
    for (std::uint64_t k = 0; k < row && event.x < width; ++k) {
      events.push_back(event);
      event.x = static_cast<std::uint16_t>(event.x + 1 + random.bits(5, 64 * i + k) % gaps);
    }
  }
  return events;
}

/// There is no writer of EVT2.
std::string evt2_of(const std::vector<Event>& events) {
  std::string bytes = "% evt 2.0\n% geometry 640x480\n% end\n";
  std::int64_t high = -1;
  for (const Event& event : events) {
    if (event.t_us >> 6 != high) {
      high = event.t_us >> 6;
      bytes += little_endian(static_cast<std::uint32_t>(8u << 28 | static_cast<std::uint32_t>(high)));
    }
    bytes += little_endian((event.on ? 1u << 28 : 0u) | static_cast<std::uint32_t>(event.t_us & 0x3f) << 22 |
                           static_cast<std::uint32_t>(event.x) << 11 | event.y);
  }
  return bytes;
}

/// The synthetic recordings, made once.
const std::filesystem::path& synthetic(const std::string& name) {
  static const TempFolder folder;
  static std::map<std::string, std::filesystem::path> made;
  if (const auto found = made.find(name); found != made.end()) return found->second;
  constexpr std::size_t count = 4'000'000;
  const ImageSize size = name == "dvs128.aedat" ? ImageSize{128, 128} : ImageSize{640, 480};
  const std::vector<Event> events = edges_and_noise(size, count);
  if (name == "evt2.raw") return made[name] = folder.write(name, evt2_of(events));
  const auto writer = create_event_file(folder / name, size);
  writer->write(events);
  writer->commit();
  return made[name] = folder / name;
}

void read_whole(benchmark::State& state, const std::filesystem::path& path) {
  std::vector<Event> events;
  std::size_t done = 0;
  for (auto _ : state) {
    const auto reader = open_event_file(path);
    events.clear();
    while (const std::size_t count = reader->read(events, 1 << 14)) {
      done += count;
      benchmark::DoNotOptimize(events.data());
      events.clear();
    }
  }
  state.SetItemsProcessed(static_cast<std::int64_t>(done));
  state.SetBytesProcessed(static_cast<std::int64_t>(std::filesystem::file_size(path)) *
                          static_cast<std::int64_t>(state.iterations()));
}

void BM_Synthetic(benchmark::State& state, const std::string& name) { read_whole(state, synthetic(name)); }
void BM_Real(benchmark::State& state, const std::string& name) {
  const std::filesystem::path path = std::filesystem::path(SACCADE_SHARED_DATA) / name;
  if (!std::filesystem::exists(path)) return state.SkipWithError("the real recordings are not there");
  read_whole(state, path);
}

BENCHMARK_CAPTURE(BM_Synthetic, EVT3, "evt3.raw");
BENCHMARK_CAPTURE(BM_Synthetic, EVT2, "evt2.raw");
BENCHMARK_CAPTURE(BM_Synthetic, AEDAT2_DVS128, "dvs128.aedat");
BENCHMARK_CAPTURE(BM_Synthetic, AEDAT2_DAVIS, "davis.aedat");
BENCHMARK_CAPTURE(BM_Synthetic, AEDAT4_LZ4, "lz4.aedat4");
BENCHMARK_CAPTURE(BM_Real, EVT3, "driving_gen41hd_evt3.raw");
BENCHMARK_CAPTURE(BM_Real, EVT2, "spinning_dot_gen3vga_evt2.raw");
BENCHMARK_CAPTURE(BM_Real, AEDAT2_DVS128, "ball_looming_dvs128_aedat2.aedat");
BENCHMARK_CAPTURE(BM_Real, AEDAT4_LZ4_head, "head_dvxplorer320x240_lz4.aedat4");
BENCHMARK_CAPTURE(BM_Real, AEDAT4_LZ4_hand, "hand_wave_dvs128_lz4.aedat4");
BENCHMARK_CAPTURE(BM_Real, EventStream, "plane_synthetic_es2_dvs.es");

}  // namespace
}  // namespace saccade
