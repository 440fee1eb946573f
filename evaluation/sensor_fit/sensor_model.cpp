#include "evaluation/sensor_fit/sensor_model.h"

#include <algorithm>
#include <cmath>

#include "emulator/event_emulator.h"

namespace saccade {

namespace {

/// The part of the load of a recording's bus that so many of its pixels make. A panel's steps let its pixels alone make events
/// at once; the other pixels' noise adds nothing then.
double bus_share(const SensorRecording& recording, std::size_t pixels) {
  const auto of_sample = static_cast<double>(pixels) / static_cast<double>(recording.places().size());
  switch (recording.stimulus().kind) {
    case StimulusKind::still:
      return 0.0;
    case StimulusKind::panel:
      return of_sample;
    case StimulusKind::board:
    case StimulusKind::disc:
      return of_sample * recording.sampled_share();
  }
  return 0.0;
}

}  // namespace

SensorModel::SensorModel(const SensorRecording& recording, std::vector<PixelPlace> places,
                         std::size_t repeats, std::uint64_t seed)
    : recording_(recording),
      places_(std::move(places)),
      repeats_(recording.stimulus().kind == StimulusKind::still ||
                       recording.stimulus().kind == StimulusKind::panel
                   ? repeats
                   : 1),
      seed_(seed),
      bus_share_(bus_share(recording, pixels())),
      times_us_(image_times_us(recording.stimulus(), recording.interval())) {
  if (pixels() * times_us_.size() > most_kept_values) return;
  images_.resize(pixels() * times_us_.size());
  ShownStimulus shown(recording.stimulus());
  for (std::size_t i = 0; i < times_us_.size(); ++i) {
    shown.move_to(recording.interval().begin_us + times_us_[i]);
    draw(shown, std::span(images_).subspan(i * pixels(), pixels()));
  }
}

void SensorModel::draw(const ShownStimulus& shown, std::span<float> image) const {
  const StimulusKind kind = recording_.stimulus().kind;
  if (kind == StimulusKind::still || kind == StimulusKind::panel) {
    std::fill(image.begin(), image.end(), shown.luminance(0.0, 0.0));
    return;
  }
  for (std::size_t i = 0; i < places_.size(); ++i) image[i] = shown.luminance(places_[i].x, places_[i].y);
}

PixelTrains SensorModel::events(EmulatorConfig config, double contrast_scale) const {
  config.hot_pixel_share = 0.0;
  config.readout_rate_hz *= bus_share_;
  if (config.readout_queue_events > 0) {
    config.readout_queue_events = std::max<std::int64_t>(
        1, std::llround(static_cast<double>(config.readout_queue_events) * bus_share_));
  }
  const std::int64_t begin_us = recording_.interval().begin_us;
  EventEmulator emulator(config, {static_cast<int>(pixels()), 1}, seed_);
  ShownStimulus shown(recording_.stimulus(), contrast_scale);
  PixelTrains trains(pixels());
  std::vector<float> image(pixels());
  std::vector<Event> events;
  const auto take = [&] {
    for (const Event& event : events) trains.add(event.x, {begin_us + event.t_us, event.on});
    events.clear();
  };
  const bool kept = !images_.empty() && contrast_scale == 1.0;
  for (std::size_t i = 0; i < times_us_.size(); ++i) {
    std::span<const float> light = image;
    if (kept) {
      light = std::span(images_).subspan(i * pixels(), pixels());
    } else {
      shown.move_to(begin_us + times_us_[i]);
      draw(shown, image);
    }
    emulator.process_image(light, times_us_[i], events);
    take();
  }
  emulator.finish(events);
  take();
  trains.finish();
  return trains;
}

}  // namespace saccade
