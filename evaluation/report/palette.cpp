#include "evaluation/report/palette.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

namespace saccade::inline v0_1 {
namespace {

constexpr std::array<std::pair<std::string_view, Colour>, 7> known_detectors = {{
    {"best", {0xd5, 0x5e, 0x00}},            // vermillion
    {"paper_full", {0x56, 0xb4, 0xe9}},      // sky blue
    {"paper_directed", {0xcc, 0x79, 0xa7}},  // reddish purple
    {"frame_30hz", {0x8c, 0x8c, 0x8c}},      // grey
    {"original_2016", {0x99, 0x99, 0x33}},   // olive
    {"cluster", {0x88, 0x22, 0x55}},         // wine
    {"multi_kernel", {0x44, 0xaa, 0x99}},    // teal
}};

constexpr std::array<Colour, 8> other_colours = {{
    {0xcc, 0x66, 0x77},  // rose
    {0x88, 0xcc, 0xee},  // cyan
    {0xb8, 0xa0, 0x3c},  // sand, darkened
    {0x11, 0x77, 0x33},  // green
    {0x8b, 0x5a, 0x2b},  // brown
    {0xd6, 0x8f, 0xe0},  // lilac
    {0x5a, 0x78, 0x8c},  // slate
    {0xf0, 0x88, 0x60},  // salmon
}};

std::optional<Colour> known(std::string_view name) {
  const auto at = std::find_if(known_detectors.begin(), known_detectors.end(),
                               [&](const auto& detector) { return detector.first == name; });
  return at == known_detectors.end() ? std::nullopt : std::optional(at->second);
}

/// FNV-1a: std::hash may differ from one library to the next.
std::size_t hash_of(std::string_view name) {
  std::uint32_t hash = 2'166'136'261U;
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 16'777'619U;
  return hash % other_colours.size();
}

}  // namespace

std::vector<Colour> detector_colours(std::span<const std::string> names) {
  std::vector<Colour> colours;
  std::array<bool, other_colours.size()> taken{};
  for (const std::string& name : names) {
    if (const auto colour = known(name)) {
      colours.push_back(*colour);
      continue;
    }
    std::size_t slot = hash_of(name);
    for (std::size_t i = 0; i < taken.size() && taken[slot]; ++i) slot = (slot + 1) % taken.size();
    taken[slot] = true;
    colours.push_back(other_colours[slot]);
  }
  return colours;
}

Colour detector_colour(const std::string& name) { return detector_colours({&name, 1}).front(); }

std::string hex(Colour colour) {
  constexpr std::string_view digits = "0123456789abcdef";
  std::string text = "#";
  for (const std::uint8_t channel : {colour.red, colour.green, colour.blue}) {
    text += digits[channel >> 4U];
    text += digits[channel & 15U];
  }
  return text;
}

}  // namespace saccade::inline v0_1
