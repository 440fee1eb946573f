#include "emulator/event_emulator.h"

#include <algorithm>
#include <limits>

#include "emulator/pixel_array.h"
#include "emulator/readout.h"

namespace saccade {
namespace {

/// Into how many bands threads share the pixels: some have more events than others.
std::size_t bands_of(std::size_t pixels, std::size_t threads) {
  constexpr std::size_t least_pixels = 16384;
  constexpr std::size_t per_thread = 8;
  if (threads == 1) return 1;
  return std::clamp(pixels / least_pixels, threads, per_thread * threads);
}

bool is_luminance(float value) { return (value >= 0.0F) & (value <= std::numeric_limits<float>::max()); }

}  // namespace

struct EventEmulator::State {
  struct Band {
    PixelArray pixels;
    std::size_t first, count;
    std::vector<PixelEvent> events;
  };

  State(const EmulatorConfig& config, ImageSize image, std::uint64_t seed,
        std::shared_ptr<WorkerThreads> threads)
      : size(image),
        readout(config, static_cast<std::size_t>(image.pixels()), seed),
        workers(std::move(threads)) {
    const auto n = static_cast<std::size_t>(image.pixels());
    const std::size_t parts = bands_of(n, workers->threads());
    for (std::size_t k = 0; k < parts; ++k) {
      const std::size_t first = n * k / parts;
      const std::size_t count = n * (k + 1) / parts - first;
      bands.push_back({PixelArray(config, first, count, seed), first, count, {}});
    }
  }

  void check(std::span<const float> luminance, std::int64_t now_us) const;
  std::span<const PixelEvent> sort_requests(std::int64_t now_us);
  void deliver(std::vector<Event>& events, std::vector<EventLabel>* labels);

  ImageSize size;
  std::vector<Band> bands;
  Readout readout;
  std::shared_ptr<WorkerThreads> workers;
  bool started = false;
  std::int64_t t_us = 0;
  EmulatorCounts counts;
  std::vector<PixelEvent> sorted;
  std::vector<PixelEvent> read_out;
  std::vector<std::uint32_t> first_at;  // counting sort by time
};

void EventEmulator::State::check(std::span<const float> luminance, std::int64_t now_us) const {
  constexpr std::int64_t longest_us = std::int64_t{1} << 60;  // so that differences of times do not overflow
  if (now_us < -longest_us || now_us > longest_us) {
    throw InputError("image at " + std::to_string(now_us) + " us", "a time out of range",
                     "a time within " + std::to_string(longest_us) + " us of 0");
  }
  if (started && now_us <= t_us) {
    throw InputError("image at " + std::to_string(now_us) + " us", "time that does not advance",
                     "a time after " + std::to_string(t_us) + " us");
  }
  std::uint32_t good = 1;  // as wide as a float, for the vectoriser
  for (const float value : luminance) good &= static_cast<std::uint32_t>(is_luminance(value));
  if (good == 1) return;
  const auto first_bad = std::find_if_not(luminance.begin(), luminance.end(), is_luminance);
  const auto at = first_bad - luminance.begin();
  throw InputError("image at " + std::to_string(now_us) + " us, pixel (" + std::to_string(at % size.width) +
                       ", " + std::to_string(at / size.width) + ")",
                   text_of(static_cast<double>(*first_bad)), "a finite luminance of at least 0");
}

/// The bands' events in the order of time and pixel.
std::span<const PixelEvent> EventEmulator::State::sort_requests(std::int64_t now_us) {
  std::size_t n = 0;
  for (const Band& band : bands) n += band.events.size();
  sorted.resize(n);
  if (now_us - t_us > 100'000) {
    auto end = sorted.begin();
    for (const Band& band : bands) end = std::copy(band.events.begin(), band.events.end(), end);
    std::stable_sort(sorted.begin(), sorted.end(),
                     [](const PixelEvent& a, const PixelEvent& b) { return a.t_us < b.t_us; });
    return sorted;
  }
  first_at.assign(static_cast<std::size_t>(now_us - t_us) + 1, 0);  // slot k: events of t_us + k + 1
  for (const Band& band : bands) {
    for (const PixelEvent& e : band.events) ++first_at[static_cast<std::size_t>(e.t_us - t_us)];
  }
  for (std::size_t k = 1; k < first_at.size(); ++k) first_at[k] += first_at[k - 1];
  for (const Band& band : bands) {
    for (const PixelEvent& e : band.events)
      sorted[first_at[static_cast<std::size_t>(e.t_us - t_us) - 1]++] = e;
  }
  return sorted;
}

void EventEmulator::State::deliver(std::vector<Event>& events, std::vector<EventLabel>* labels) {
  const auto width = static_cast<std::uint32_t>(size.width);
  for (const PixelEvent& e : read_out) {
    events.push_back({e.t_us, static_cast<std::uint16_t>(e.pixel % width),
                      static_cast<std::uint16_t>(e.pixel / width), e.on, 0});
    if (labels != nullptr) labels->push_back({static_cast<EventCause>(e.cause), e.object});
    ++(e.on ? counts.on : counts.off);
    ++counts.by_cause[e.cause];
  }
  counts.dropped = readout.dropped();
  counts.waiting = readout.waiting();
}

EventEmulator::EventEmulator(const EmulatorConfig& config, ImageSize size, std::uint64_t seed, int threads)
    : EventEmulator(config, size, seed,
                    std::make_shared<WorkerThreads>(static_cast<std::size_t>(std::max(threads, 0)))) {}

EventEmulator::EventEmulator(const EmulatorConfig& config, ImageSize size, std::uint64_t seed,
                             std::shared_ptr<WorkerThreads> threads) {
  check_config("emulator", config);
  SACCADE_CHECK(size.width > 0 && size.height > 0 && size.width <= 65535 && size.height <= 65535);
  state_ = std::make_unique<State>(config, size, seed, std::move(threads));
}

EventEmulator::~EventEmulator() = default;
EventEmulator::EventEmulator(EventEmulator&&) noexcept = default;
EventEmulator& EventEmulator::operator=(EventEmulator&&) noexcept = default;

void EventEmulator::process_image(std::span<const float> luminance, std::int64_t t_us,
                                  std::vector<Event>& events, std::vector<EventLabel>* labels,
                                  std::span<const std::uint8_t> objects) {
  State& s = *state_;
  const auto n = static_cast<std::size_t>(s.size.pixels());
  SACCADE_CHECK(luminance.size() == n && (objects.empty() || objects.size() == n));
  s.check(luminance, t_us);
  s.workers->run(s.bands.size(), [&](std::size_t k) {
    State::Band& band = s.bands[k];
    const auto of_band = [&](auto whole) {
      return whole.empty() ? whole : whole.subspan(band.first, band.count);
    };
    band.pixels.process(of_band(luminance), of_band(objects), t_us, band.events);
  });
  s.read_out.clear();
  if (s.started) s.readout.process(s.sort_requests(t_us), t_us, s.read_out);
  s.deliver(events, labels);
  s.started = true;
  s.t_us = t_us;
}

void EventEmulator::finish(std::vector<Event>& events, std::vector<EventLabel>* labels) {
  state_->read_out.clear();
  state_->readout.finish(state_->read_out);
  state_->deliver(events, labels);
}

const EmulatorCounts& EventEmulator::counts() const { return state_->counts; }

double EventEmulator::reference_log(std::size_t pixel) const {
  for (const State::Band& band : state_->bands) {
    if (pixel < band.first + band.count) return band.pixels.reference_log(pixel - band.first);
  }
  SACCADE_CHECK(false && "a pixel of the image");
}

double EventEmulator::output_log(std::size_t pixel) const {
  for (const State::Band& band : state_->bands) {
    if (pixel < band.first + band.count) return band.pixels.output_log(pixel - band.first);
  }
  SACCADE_CHECK(false && "a pixel of the image");
}

}  // namespace saccade
