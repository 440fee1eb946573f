#include "apps/view/colours.h"

#include "evaluation/report/figures.h"

namespace saccade::colours {

ImU32 of_hex(const std::string& hex) {
  const auto channel = [&](std::size_t at) { return std::stoi(hex.substr(at, 2), nullptr, 16); };
  return IM_COL32(channel(1), channel(3), channel(5), 255);
}

ImU32 detector(const ViewSettings& settings, const std::string& name) {
  std::size_t index = 0;
  for (std::size_t i = 0; i < settings.detectors.size(); ++i) {
    if (settings.detectors[i].name == name) index = i;
  }
  const std::string hex = detector_colour(index);
  const auto channel = [&](std::size_t at) {
    const int value = std::stoi(hex.substr(at, 2), nullptr, 16);
    return value + (255 - value) * 3 / 10;
  };
  return IM_COL32(channel(1), channel(3), channel(5), 255);
}

}  // namespace saccade::colours
