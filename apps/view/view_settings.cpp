#include "apps/view/view_settings.h"

#include <algorithm>

namespace saccade {

std::size_t ViewSettings::selected_in_loop() const {
  const auto end = detectors.begin() + static_cast<std::ptrdiff_t>(std::min(selected, detectors.size()));
  return static_cast<std::size_t>(
      std::count_if(detectors.begin(), end, [](const auto& d) { return d.enabled; }));
}

NamedDetectors ViewSettings::enabled() const {
  NamedDetectors enabled;
  for (const ViewDetector& detector : detectors) {
    if (detector.enabled) enabled.emplace_back(detector.name, detector.config);
  }
  return enabled;
}

ViewSettings view_settings(const NamedDetectors& detectors, const std::string& selected) {
  ViewSettings settings;
  for (std::size_t i = 0; i < detectors.size(); ++i) {
    settings.detectors.push_back({detectors[i].first, detectors[i].second, true});
    if (detectors[i].first == selected) settings.selected = i;
  }
  return settings;
}

}  // namespace saccade
