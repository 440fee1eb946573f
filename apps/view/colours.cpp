#include "apps/view/colours.h"

#include <algorithm>
#include <vector>

namespace saccade::inline v0_1::colours {

ImU32 detector(const ViewSettings& settings, const std::string& name) {
  std::vector<std::string> names;
  for (const ViewDetector& detector : settings.detectors) names.push_back(detector.name);
  const auto it = std::ranges::find(names, name);
  if (it == names.end()) return of(detector_colour(name));
  return of(detector_colours(names)[static_cast<std::size_t>(it - names.begin())]);
}

}  // namespace saccade::inline v0_1::colours
