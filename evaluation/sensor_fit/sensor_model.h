#pragma once

#include <memory>
#include <span>
#include <vector>

#include "emulator/emulator_config.h"
#include "evaluation/sensor_fit/pixel_trains.h"
#include "evaluation/sensor_fit/sensor_recording.h"

namespace saccade {

/// The event camera's emulator before a stimulus: what a sensor with given parameters would have recorded.
class SensorModel {
 public:
  /// Pixels at `places` of the recording, which must outlive the model; for a still scene and a panel `repeats` pixels for
  /// each of them.
  SensorModel(const SensorRecording& recording, std::vector<PixelPlace> places, std::size_t repeats,
              std::uint64_t seed);

  /// In the recording's clock. Without hot pixels. The bus is slower in proportion to what these pixels add to its load, so that
  /// events wait for it as long as in the recording; it delays no event of a still scene.
  [[nodiscard]] PixelTrains events(EmulatorConfig config, double contrast_scale = 1.0) const;
  [[nodiscard]] std::size_t pixels() const { return places_.size() * repeats_; }

  static constexpr std::size_t most_kept_values = std::size_t{1}
                                                  << 25;  ///< luminances of all images together

 private:
  void draw(const ShownStimulus& shown, std::span<float> image) const;

  const SensorRecording& recording_;
  std::vector<PixelPlace> places_;
  std::size_t repeats_;
  std::uint64_t seed_;
  double bus_share_;  // of the bus' rate; 0: no limit
  std::vector<std::int64_t> times_us_;
  std::vector<float>
      images_;  // of a contrast scale of 1, one after the other; empty where they would need too much memory
};

}  // namespace saccade
