#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/event.h"
#include "emulator/emulator_config.h"

namespace saccade {

/// Why an event was made.
enum class EventCause : std::uint8_t { signal, leak, shot, hot };

/// What the emulator knows of an event and no sensor tells. Truth: not for a detector.
struct EventLabel {
  EventCause cause =
      EventCause::signal;   ///< leak where leakage was more than half of the way to the threshold
  std::uint8_t object = 0;  ///< of the pixel, as process_image was told; 0 where it was not

  friend bool operator==(const EventLabel&, const EventLabel&) = default;
};

/// Of all events so far.
struct EmulatorCounts {
  std::int64_t on = 0;
  std::int64_t off = 0;
  std::int64_t by_cause[4] = {};  ///< in the order of EventCause
  std::int64_t dropped = 0;       ///< lost because the readout's queue was full; not among the others
  std::int64_t waiting = 0;       ///< made and not yet appended: later than the newest image

  [[nodiscard]] std::int64_t events() const { return on + off; }
};

/// Turns a sequence of luminance images into the events of a dynamic vision sensor (Lichtsteiner, Posch,
/// Delbruck, JSSC 43(2), 2008), each stamped with its own crossing time. EmulatorConfig has the stages.
///
/// A pixel holds a reference level and emits when its photoreceptor's output has moved by a threshold from it;
/// the reference is then the level where that happened, or, with a refractory period, the output at the end of
/// it. Noise events reset the pixel like any other. An event is stamped with the first whole microsecond at or
/// after the crossing, plus latency and readout; a second one of the same pixel within a tick comes a tick later.
///
/// Events and their times do not depend on how finely a given course of light is sampled, on the number of
/// threads, or on the compiler; they are a pure function of configuration, size, seed and images.
class EventEmulator {
 public:
  /// `threads`: how many to use. Throws InputError for a configuration out of range.
  EventEmulator(const EmulatorConfig& config, ImageSize size, std::uint64_t seed, int threads = 1);
  ~EventEmulator();
  EventEmulator(EventEmulator&&) noexcept;
  EventEmulator& operator=(EventEmulator&&) noexcept;

  /// Takes the image at t_us and appends the events with stamps in (previous t_us, t_us], sorted by time and, within
  /// a microsecond, in the order of the readout; without one by row and column. The first image sets the references and makes no event. Intervals
  /// between images may be of any length.
  /// `luminance`: size.height x size.width, row by row, linear light, >= 0.
  /// `labels`: where given, one per appended event. `objects`: where given, the object at each pixel in this
  /// image; an event takes the smaller number of the pixel in the images before and after it.
  /// Throws InputError when time does not advance or a value is negative or not finite (nothing is changed).
  void process_image(std::span<const float> luminance, std::int64_t t_us, std::vector<Event>& events,
                     std::vector<EventLabel>* labels = nullptr, std::span<const std::uint8_t> objects = {});

  /// Appends the events that are still on their way (latency, readout) after the last image.
  void finish(std::vector<Event>& events, std::vector<EventLabel>* labels = nullptr);

  [[nodiscard]] const EmulatorCounts& counts() const;

  /// For tests that rebuild the image from events: a pixel's reference, and its photoreceptor's output at the
  /// newest image, both as log luminance (without what has leaked).
  [[nodiscard]] double reference_log(std::size_t pixel) const;
  [[nodiscard]] double output_log(std::size_t pixel) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace saccade
