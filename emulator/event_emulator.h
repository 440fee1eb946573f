#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/event.h"
#include "emulator/emulator_config.h"
#include "emulator/event_label.h"
#include "threads/worker_threads.h"

namespace saccade {

/// Counts of all events since the start.
struct EmulatorCounts {
  std::int64_t on = 0;
  std::int64_t off = 0;
  std::array<std::int64_t, event_cause_names.size()> by_cause = {};  ///< in the order of EventCause
  std::int64_t dropped = 0;  ///< dropped because the readout's queue was full; not part of the other counts
  std::int64_t waiting = 0;  ///< made but later than the newest image, so not yet appended

  [[nodiscard]] std::int64_t events() const { return on + off; }
};

/// An emulator of a dynamic vision sensor (Lichtsteiner, Posch, Delbruck, JSSC 43(2), 2008): a sequence of luminance
/// images in, events out, each stamped with the time of its own threshold crossing. EmulatorConfig lists the stages.
///
/// A pixel emits an event when its photoreceptor's output differs by a threshold from the pixel's reference level. The
/// new reference is the level of the crossing or, with a refractory period, the output at the end of that period. Noise
/// events reset the pixel like signal events. The stamp is the first whole microsecond at or after the crossing, plus
/// latency and readout; a second event of a pixel within a tick of the clock is stamped one tick later.
///
/// Events and their times do not depend on how finely a given change of light is sampled, on the number of threads or
/// on the compiler: they are a pure function of configuration, size, seed and images.
class EventEmulator {
 public:
  /// `size`: of the images, at most 65535 x 65535. `threads`: number of threads, at least 1. Throws InputError for a
  /// configuration out of range.
  EventEmulator(const EmulatorConfig& config, ImageSize size, std::uint64_t seed, int threads = 1);
  /// With threads that others use too, between calls of process_image().
  EventEmulator(const EmulatorConfig& config, ImageSize size, std::uint64_t seed,
                std::shared_ptr<WorkerThreads> threads);
  ~EventEmulator();
  EventEmulator(EventEmulator&&) noexcept;
  EventEmulator& operator=(EventEmulator&&) noexcept;

  /// Processes the image at t_us and appends the events with stamps in (previous t_us, t_us], sorted by time and,
  /// within a microsecond, in the order of the readout, or by row and column without a readout. The first image sets
  /// the references and makes no event. Intervals between images may have any length; times lie within 2^60 us
  /// (36,000 years) of 0.
  /// `luminance`: size.height x size.width, row by row, linear light, >= 0.
  /// `labels`: if not null, receives one label per appended event. `objects`: if not empty, the number of the object in
  /// each pixel of this image; an event's label has the smaller number of its pixel in the images before and after it.
  /// Throws InputError, and changes nothing, for a time that is out of range or not after the previous one, and for a
  /// luminance that is negative or not finite.
  void process_image(std::span<const float> luminance, std::int64_t t_us, std::vector<Event>& events,
                     std::vector<EventLabel>* labels = nullptr, std::span<const std::uint8_t> objects = {});

  /// Appends the events of the last image that latency and readout still delay.
  void finish(std::vector<Event>& events, std::vector<EventLabel>* labels = nullptr);

  [[nodiscard]] const EmulatorCounts& counts() const;

  /// For tests that reconstruct the image from events: a pixel's reference level, and its photoreceptor's output at the
  /// newest image, both as log luminance without leakage.
  [[nodiscard]] double reference_log(std::size_t pixel) const;
  [[nodiscard]] double output_log(std::size_t pixel) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace saccade
