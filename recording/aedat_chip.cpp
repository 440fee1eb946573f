#include "recording/aedat_chip.h"

#include <algorithm>
#include <array>
#include <cctype>

#include "recording/codec.h"

namespace saccade {
namespace {

struct KnownChip {
  std::string_view name;  ///< how the name of a chip or of its class begins; no digit follows
  const char* layout;
  ImageSize size;
};
constexpr std::array<KnownChip, 12> known_chips = {{{"dvs128stereopair", "stereo", aedat_dvs128_size},
                                                    {"dvs128", "dvs128", aedat_dvs128_size},
                                                    {"tmpdiff128", "dvs128", aedat_dvs128_size},
                                                    {"dvs640", "dvs640", aedat_dvs640_size},
                                                    {"sbret10", "davis", {240, 180}},
                                                    {"dvs240", "davis", {240, 180}},
                                                    {"davi346", "davis", {346, 260}},
                                                    {"davis128", "davis", {128, 128}},
                                                    {"davis208", "davis", {208, 192}},
                                                    {"davis240", "davis", {240, 180}},
                                                    {"davis346", "davis", {346, 260}},
                                                    {"davis640", "davis", {640, 480}}}};
constexpr std::array<std::string_view, 3> unknown_kinds = {"cochlea", "multi", "stereo"};

}  // namespace

AedatChip parse_aedat_chip(std::string_view name) {
  std::string chip(name);
  std::transform(chip.begin(), chip.end(), chip.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  chip.erase(0, chip.rfind('.') + 1);  // the package of a class; npos + 1 is 0
  for (const KnownChip& known : known_chips) {
    if (!chip.starts_with(known.name)) continue;
    const std::string_view rest = std::string_view(chip).substr(known.name.size());
    const bool is_longer_number = !rest.empty() && std::isdigit(static_cast<unsigned char>(rest[0])) != 0;
    const bool is_other = std::ranges::any_of(
        unknown_kinds, [&](std::string_view kind) { return rest.find(kind) != std::string_view::npos; });
    if (is_longer_number || is_other) return {};
    return {known.layout, known.size};
  }
  if (chip.starts_with("davis ")) return {"davis", parse_size(std::string_view(chip).substr(6))};
  const bool is_davis = chip.starts_with("davis") || chip == "cdavis";
  const bool is_other = std::ranges::any_of(
      unknown_kinds, [&](std::string_view kind) { return chip.find(kind) != std::string_view::npos; });
  return is_davis && !is_other ? AedatChip{"davis", std::nullopt} : AedatChip{};
}

}  // namespace saccade
