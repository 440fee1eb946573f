#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "evaluation/sensor_fit/pixel_trains.h"
#include "evaluation/sensor_fit/stimulus.h"

namespace saccade {

/// A statistic of events that is the ratio of two sums over pixels. The sums are kept for 16 groups of pixels, so that the
/// jackknife gives its standard deviation.
struct Feature {
  static constexpr std::size_t groups = 16;

  std::string name;
  std::array<double, groups> numerator{};
  std::array<double, groups> denominator{};

  /// NaN where the denominator is 0.
  [[nodiscard]] double value() const;
  /// Leaving out one group at a time; NaN where a group holds everything.
  [[nodiscard]] double deviation() const;
};

/// The features of a recording of `stimulus`. The same stimulus and interval give the same features in the same order,
/// whatever the events:
///   still  rate, variance and intervals of ON and OFF events
///   panel  for each step: events per pixel, the share of pixels with 1, 2, ... events, the time of the first ones;
///          how much ON and OFF counts differ from pixel to pixel
///   board, disc  rate and variance of ON and OFF events, length of runs of one polarity, intervals in a run, how
///          much the ratio of ON to OFF events differs from pixel to pixel
[[nodiscard]] std::vector<Feature> features_of(const Stimulus& stimulus, StimulusInterval interval,
                                               const PixelTrains& trains);

/// For each pixel and step of a panel in each period: what happened until the next step.
struct PanelResponse {
  std::size_t pixel = 0;
  std::size_t step = 0;  ///< of steps_of()
  std::int64_t begin_us = 0;
  std::vector<TrainEvent> events;
};
[[nodiscard]] std::vector<PanelResponse> panel_responses(const Stimulus& panel, StimulusInterval interval,
                                                         const PixelTrains& trains);

}  // namespace saccade
