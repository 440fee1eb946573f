#include "evaluation/report/palette.h"

#include <algorithm>
#include <array>
#include <utility>

namespace saccade {
namespace {

constexpr std::array<std::pair<std::string_view, Colour>, 13> known_detectors = {{
    {"best", {0xd5, 0x5e, 0x00}},             // vermillion
    {"paper_full", {0x56, 0xb4, 0xe9}},       // sky blue
    {"paper_directed", {0xcc, 0x79, 0xa7}},   // reddish purple
    {"frame_30hz", {0x8c, 0x8c, 0x8c}},       // grey
    {"original_2016", {0x99, 0x99, 0x33}},    // olive
    {"cluster", {0x88, 0x22, 0x55}},          // wine
    {"multi_kernel", {0x44, 0xaa, 0x99}},     // teal
    {"lifetime", {0x50, 0xd7, 0x62}},         // light green
    {"single_radius", {0x74, 0x62, 0x1a}},    // brown
    {"eros", {0xf2, 0x86, 0xfb}},             // pink
    {"scarf", {0x08, 0x7d, 0x08}},            // green
    {"particle_filter", {0xfb, 0x98, 0x8f}},  // salmon
    {"blob_filter", {0xaa, 0xbc, 0x8f}},      // sage
}};

// Each as far as possible from those before it, from the known detectors' and from those of events, truth and gaze.
constexpr std::array<Colour, 14> other_colours = {{
    {0xc5, 0xaa, 0xd7},  // thistle
    {0x08, 0x8f, 0xfb},  // azure
    {0x74, 0x59, 0x7d},  // plum
    {0xbc, 0x08, 0x35},  // crimson
    {0xa1, 0x8f, 0xfb},  // lavender
    {0x47, 0xaa, 0x08},  // grass green
    {0xbc, 0x62, 0xe0},  // orchid
    {0x7d, 0x3e, 0xbc},  // purple
    {0x35, 0xce, 0xc5},  // turquoise
    {0xb3, 0xbc, 0x08},  // lime
    {0xd7, 0x3e, 0x7d},  // cerise
    {0x47, 0x50, 0xce},  // royal blue
    {0x98, 0x47, 0x50},  // redwood
    {0x6b, 0x86, 0x11},  // moss
}};

/// FNV-1a with a final mix of the bits: std::hash may differ from one library to the next.
std::uint32_t hash_of(std::string_view name) {
  std::uint32_t hash = 2'166'136'261U;
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 16'777'619U;
  hash = (hash ^ (hash >> 16U)) * 0x7feb'352dU;
  hash = (hash ^ (hash >> 15U)) * 0x846c'a68bU;
  return hash ^ (hash >> 16U);
}

}  // namespace

Colour detector_colour(std::string_view name) {
  const auto known = std::ranges::find(known_detectors, name, &std::pair<std::string_view, Colour>::first);
  if (known != known_detectors.end()) return known->second;
  const std::uint32_t hash = hash_of(name);
  const Colour& full = other_colours[hash % other_colours.size()];
  // Names that share one of them hardly share the shade.
  const auto shaded = [&](std::uint8_t channel, unsigned shift) {
    return static_cast<std::uint8_t>(channel * (224 + (hash >> shift) % 32) / 255);
  };
  return {shaded(full.red, 16), shaded(full.green, 21), shaded(full.blue, 26)};
}

std::string hex(Colour colour) {
  constexpr std::string_view digits = "0123456789abcdef";
  std::string text = "#";
  for (const std::uint8_t channel : {colour.red, colour.green, colour.blue}) {
    text += digits[channel >> 4U];
    text += digits[channel & 15U];
  }
  return text;
}

}  // namespace saccade
