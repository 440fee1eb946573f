#include "recording/aedat_chip.h"

#include <algorithm>
#include <cctype>

#include "recording/codec.h"

namespace saccade::inline v0_1 {

AedatChip parse_aedat_chip(std::string_view name) {
  std::string chip(name);
  std::transform(chip.begin(), chip.end(), chip.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (chip.find("dvs128stereopair") != std::string::npos) return {"stereo", aedat_dvs128_size};
  if (chip.find("dvs128") != std::string::npos) return {"dvs128", aedat_dvs128_size};
  const std::size_t davis = chip.rfind("davis");
  if (davis == std::string::npos) return {};
  const std::string model = chip.substr(davis + 5);
  if (model.starts_with(' ')) return {"davis", parse_size(std::string_view(model).substr(1))};
  for (const ImageSize size : aedat_davis_sizes) {
    if (model.starts_with(std::to_string(size.width))) return {"davis", size};
  }
  return {"davis", std::nullopt};
}

}  // namespace saccade::inline v0_1
