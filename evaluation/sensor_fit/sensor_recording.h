#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/event.h"
#include "evaluation/sensor_fit/pixel_trains.h"
#include "evaluation/sensor_fit/stimulus.h"

namespace saccade {

/// The place of a pixel.
struct PixelPlace {
  std::uint16_t x = 0;
  std::uint16_t y = 0;
  friend bool operator==(const PixelPlace&, const PixelPlace&) = default;
};

/// A recording of a known stimulus: the events of a sample of pixels, and what the events of all pixels say about bus,
/// clock and hot pixels.
class SensorRecording {
 public:
  /// At most so many pixels of the stimulus' region are sampled, spread evenly over it.
  static constexpr std::size_t most_pixels = 8192;

  /// `first_us`, `last_us`: of the whole recording. Throws InputError where the stimulus and the recording share no time,
  /// or the region lies outside the image.
  SensorRecording(std::string name, Stimulus stimulus, ImageSize size, std::int64_t first_us,
                  std::int64_t last_us);

  /// All events of the recording in its order, in blocks.
  void add(std::span<const Event> events);
  /// After the last event.
  void finish();
  /// Leaves pixels out of the sample.
  void drop(std::span<const PixelPlace> hot);

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const Stimulus& stimulus() const { return stimulus_; }
  [[nodiscard]] StimulusInterval interval() const { return interval_; }
  [[nodiscard]] ImageSize size() const { return size_; }
  [[nodiscard]] const std::vector<PixelPlace>& places() const { return places_; }
  [[nodiscard]] const PixelTrains& trains() const { return trains_; }
  /// Share of the interval's events that the sampled pixels made; 1 without any event.
  [[nodiscard]] double sampled_share() const;

  /// Pixels of a still scene that make many times more ON events than the others; and their rate above the median.
  struct HotPixels {
    std::vector<PixelPlace> places;
    double rate_hz = 0.0;
  };
  [[nodiscard]] HotPixels hot_pixels() const;
  /// The largest number of events in a millisecond, per second; and whether the bus is busy all through the 20 fullest
  /// milliseconds: they hold the same number to 1 %, and the tenths of each vary by much less than chance gives.
  struct Readout {
    double rate_hz = 0.0;
    bool is_busy = false;
  };
  [[nodiscard]] Readout readout() const;
  /// The tick of which all time stamps are multiples, counted from the first.
  [[nodiscard]] std::int64_t tick_us() const { return tick_us_; }

 private:
  struct Millisecond {
    std::int64_t events = 0;
    double variation = 0.0;  // variance of its tenths over their mean: 1 of a Poisson process
    friend bool operator>(const Millisecond& a, const Millisecond& b) { return a.events > b.events; }
  };
  void end_millisecond();

  std::string name_;
  Stimulus stimulus_;
  ImageSize size_;
  StimulusInterval interval_;
  std::array<int, 4> region_{};  // x, y, width and height
  std::vector<PixelPlace> places_;
  std::vector<std::int32_t> number_;      // in places_, of each pixel of the image; -1: not in the sample
  std::vector<std::uint32_t> on_counts_;  // of each pixel of the image, of a still scene
  PixelTrains trains_{0};
  std::int64_t in_interval_ = 0;  // events of all pixels
  std::optional<std::int64_t> first_stamp_us_;
  std::int64_t tick_us_ = 0;
  std::int64_t millisecond_ = 0;
  std::int64_t in_millisecond_ = 0;
  std::array<std::int64_t, 10> tenths_{};  // of the millisecond
  std::vector<Millisecond> fullest_;
};

}  // namespace saccade
