#include "evaluation/report/run_head.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/units.h"
#include "evaluation/report/html.h"
#include "evaluation/report/run_tables.h"
#include "evaluation/report/templates.h"
#include "recording/run_file_names.h"

namespace saccade {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t most_detector_cards = 3;

/// 1234567 as "1 234 567", with spaces that do not break.
std::string grouped_digits(std::int64_t count) {
  std::string text = std::to_string(count);
  for (std::ptrdiff_t at = std::ssize(text) - 3; at > (count < 0 ? 1 : 0); at -= 3)
    text.insert(static_cast<std::size_t>(at), "\u202f");
  return text;
}

/// A share of 0 to 1 in percent; never 100 % or 0 % of what is not all or nothing.
std::string percent(double share) {
  const double value = 100.0 * share;
  if (share > 0.0 && value < 0.1) return "below 0.1 %";
  if (share < 1.0 && value > 99.9) return "above 99.9 %";
  return value >= 99.0 || value < 1.0 ? fmt::format("{:.3g} %", value) : fmt::format("{:.0f} %", value);
}

Json card(const std::string& value, const std::string& words) { return {{"value", value}, {"words", words}}; }

void add_gaze_cards(Json& cards, const GazeMetrics& gaze) {
  const GazeScore& s = gaze.score;
  cards.push_back(
      s.acquire_s ? card(fmt::format("{:.2f} s", *s.acquire_s),
                         fmt::format("from the ball’s first motion until the gaze was within {:.3g}° of it",
                                     s.acquire_within_deg))
                  : card("never", "was the gaze on the ball"));
  if (s.on_target_ratio)
    cards.push_back(
        card(percent(*s.on_target_ratio), "of the time from then on the gaze was within 2° of the ball"));
  if (s.fixation_error_deg.median)
    cards.push_back(card(fmt::format("{:.2f}°", *s.fixation_error_deg.median), "gaze error, median"));
  if (s.moves > 0)
    cards.push_back(card(grouped_digits(s.wrong_moves),
                         fmt::format("of {} gaze moves went to something else", grouped_digits(s.moves))));
}

/// What a detector achieved at its threshold.
std::string detector_words(const Metrics& m, std::size_t i) {
  const DetectorScore& s = m.detectors[i].second;
  std::string words = "average precision of " + detector_mark(m, i);
  if (s.recall && s.precision)
    words += fmt::format(
        ". At its threshold it finds the ball in {} of the instants, and {} of its reports are right",
        percent(*s.recall), percent(*s.precision));
  if (s.position_error_px.median)
    words += fmt::format("; median error {:.2f} px", *s.position_error_px.median);
  return words;
}

void add_detector_cards(Json& cards, const Metrics& m) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < m.detectors.size(); ++i) {
    if (m.detectors[i].second.average_precision) order.push_back(i);
  }
  const auto rank = [&](std::size_t i) {
    const bool drives = m.gaze && m.gaze->detector == m.detectors[i].first;
    return std::pair(drives, *m.detectors[i].second.average_precision);
  };
  std::ranges::stable_sort(order, std::ranges::greater{}, rank);
  for (std::size_t k = 0; k < std::min(order.size(), most_detector_cards); ++k)
    cards.push_back(card(fmt::format("{:.2f}", *m.detectors[order[k]].second.average_precision),
                         detector_words(m, order[k])));
}

std::string camera_text(const Metrics& m) {
  std::string text = fmt::format("{} × {} pixels", m.image.width, m.image.height);
  if (!m.camera) return text;
  const double fov_deg = 2.0 * std::atan(0.5 * m.image.width / m.camera->fx_px) * deg_per_rad;
  return text + fmt::format(", focal length {:.1f} px (about {:.0f}° wide)", m.camera->fx_px, fov_deg);
}

std::string events_text(const Metrics& m) {
  std::string text = grouped_digits(m.event_count);
  if (m.duration_s > 0.0)
    text += fmt::format(" ({} per second)",
                        grouped_digits(std::llround(static_cast<double>(m.event_count) / m.duration_s)));
  if (!m.events_dropped) return text + "; how many were dropped is not known";
  if (*m.events_dropped == 0) return text + "; none dropped";
  return text + fmt::format("; {} dropped ({} of all)", grouped_digits(*m.events_dropped),
                            percent(dropped_share(m).value_or(0.0)));
}

/// The first line of the resolved configuration, which names versions; and its description.
struct Origin {
  std::string versions;
  std::string description;
};

Origin origin_of(const std::filesystem::path& folder) {
  Origin origin;
  for (const char* name : {run_file::scenario, run_file::detectors, run_file::robot}) {
    std::ifstream file(folder / name, std::ios::binary);
    if (!file) continue;
    for (std::string line; std::getline(file, line);) {
      constexpr std::string_view description = "description: ";
      if (line.starts_with("# saccade ")) origin.versions = line.substr(2);
      if (!line.starts_with(description)) continue;
      origin.description = line.substr(description.size());
      if (origin.description.size() > 1 && origin.description.front() == '"')
        origin.description = origin.description.substr(1, origin.description.size() - 2);
    }
    break;
  }
  return origin;
}

}  // namespace

std::string run_head(const RunData& run) {
  const Metrics& m = run.metrics;
  const Origin origin = origin_of(run.folder);
  Json cards = Json::array();
  if (m.gaze) add_gaze_cards(cards, *m.gaze);
  add_detector_cards(cards, m);
  Json facts = Json::array();
  const auto fact = [&](const char* name, const std::string& value) {
    if (!value.empty()) facts.push_back({{"name", name}, {"value", value}});
  };
  fact("Scenario", m.scenario);
  const std::size_t semicolon = origin.versions.find("; ");
  fact("Version and commit", origin.versions.substr(0, semicolon));
  if (semicolon != std::string::npos) fact("Drawn by", origin.versions.substr(semicolon + 2));
  if (m.seed) fact("Seed", std::to_string(*m.seed));
  std::string settings;
  for (const auto& [key, value] : m.settings)
    settings += (settings.empty() ? "" : ", ") + key + " = " + value;
  fact("Settings", settings);
  if (m.latency) fact("Latency", m.latency->kind);
  fact("Camera", camera_text(m));
  fact("Events", events_text(m));
  std::string duration = fmt::format("{:.3g} s", m.duration_s);
  if (m.wall_s && *m.wall_s > 0.0)
    duration +=
        fmt::format(", computed in {:.3g} s ({:.2g} × real time)", *m.wall_s, m.duration_s / *m.wall_s);
  fact("Duration", duration);
  std::string warning = dropped_warning(m);
  if (!warning.empty()) {
    warning.front() = 'T';
    warning += ".";
  }
  return rendered("run_head.mustache",
                  {{"description", origin.description.empty() ? Json(false) : Json(origin.description)},
                   {"warning", warning.empty() ? Json(false) : Json(warning)},
                   {"cards", !cards.empty()},
                   {"card", std::move(cards)},
                   {"fact", std::move(facts)}});
}

}  // namespace saccade
