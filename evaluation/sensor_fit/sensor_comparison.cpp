#include <algorithm>
#include <cmath>
#include <map>

#include "evaluation/sensor_fit/event_features.h"
#include "evaluation/sensor_fit/sensor_fit.h"
#include "evaluation/sensor_fit/sensor_model.h"

namespace saccade {
namespace {

constexpr std::size_t most_values = 20'000;

/// The values of each quantity.
using Quantities = std::map<std::string, std::vector<double>>;

constexpr const char* rate_name = "events per pixel and second";
constexpr const char* share_name = "share of ON events of a pixel";
constexpr const char* interval_name = "interval between events of a pixel [us]";
constexpr const char* response_name = "contrast response: events per change of light";

Quantities quantities_of(const SensorRecording& recording, const PixelTrains& trains) {
  Quantities q;
  const double duration_s =
      static_cast<double>(recording.interval().end_us - recording.interval().begin_us) * 1e-6;
  for (std::size_t pixel = 0; pixel < trains.pixels(); ++pixel) {
    const auto train = trains.of(pixel);
    q[rate_name].push_back(static_cast<double>(train.size()) / duration_s);
    const auto on = std::count_if(train.begin(), train.end(), [](const TrainEvent& e) { return e.on; });
    if (!train.empty()) q[share_name].push_back(static_cast<double>(on) / static_cast<double>(train.size()));
    double run = 0.0;
    for (std::size_t i = 0; i < train.size(); ++i) {
      if (i > 0) q[interval_name].push_back(static_cast<double>(train[i].t_us - train[i - 1].t_us));
      run += 1.0;
      if (recording.stimulus().kind == StimulusKind::panel || !recording.stimulus().moves()) continue;
      if (i + 1 < train.size() && train[i + 1].on == train[i].on) continue;
      q[response_name].push_back(run);
      run = 0.0;
    }
  }
  if (recording.stimulus().kind == StimulusKind::panel) {
    for (const PanelResponse& response :
         panel_responses(recording.stimulus(), recording.interval(), trains)) {
      q[response_name].push_back(static_cast<double>(response.events.size()));
    }
  }
  for (auto& [name, values] : q) {
    if (values.size() > most_values) {
      std::vector<double> some(most_values);
      for (std::size_t i = 0; i < most_values; ++i) some[i] = values[i * values.size() / most_values];
      values = std::move(some);
    }
    std::sort(values.begin(), values.end());
  }
  return q;
}

/// The largest difference of two empirical distribution functions; both sorted.
double ks_distance(const std::vector<double>& a, const std::vector<double>& b) {
  if (a.empty() || b.empty()) return a.empty() == b.empty() ? 0.0 : 1.0;
  double largest = 0.0;
  std::size_t i = 0, k = 0;
  while (i < a.size() && k < b.size()) {
    const double value = std::min(a[i], b[k]);
    while (i < a.size() && a[i] <= value) ++i;
    while (k < b.size() && b[k] <= value) ++k;
    largest = std::max(largest, std::abs(static_cast<double>(i) / static_cast<double>(a.size()) -
                                         static_cast<double>(k) / static_cast<double>(b.size())));
  }
  return largest;
}

}  // namespace

std::vector<ComparedDistribution> compare_distributions(const std::vector<SensorRecording>& recordings,
                                                        const EmulatorConfig& before,
                                                        const EmulatorConfig& after,
                                                        const std::vector<double>& contrast_scales,
                                                        std::uint64_t seed) {
  std::vector<ComparedDistribution> all;
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    const SensorRecording& recording = recordings[r];
    std::vector<PixelPlace> places;
    for (std::size_t i = 1; i < recording.places().size(); i += 2) places.push_back(recording.places()[i]);
    const std::size_t repeats = std::max<std::size_t>(1, 512 / std::max<std::size_t>(1, places.size()));
    const SensorModel model(recording, places, repeats, seed);
    Quantities recorded = quantities_of(recording, recording.trains().half(true));
    Quantities of_prior = quantities_of(recording, model.events(before));
    Quantities of_fit = quantities_of(recording, model.events(after, contrast_scales[r]));
    for (const char* name : {rate_name, share_name, interval_name, response_name}) {
      if (recorded[name].empty()) continue;
      ComparedDistribution& d = all.emplace_back();
      d.recording = recording.name();
      d.quantity = name;
      d.logarithmic = name == interval_name;
      d.recorded = std::move(recorded[name]);
      d.before = std::move(of_prior[name]);
      d.after = std::move(of_fit[name]);
      d.ks_before = ks_distance(d.recorded, d.before);
      d.ks_after = ks_distance(d.recorded, d.after);
    }
  }
  return all;
}

}  // namespace saccade
