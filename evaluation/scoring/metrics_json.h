#pragma once

#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <type_traits>

#include "evaluation/scoring/eye_movement_score.h"
#include "evaluation/scoring/scoring.h"

namespace saccade::metrics_json {

/// The parts of metrics.json that several of its writers and readers use. None is null.

using Json = nlohmann::ordered_json;

inline Json json_of(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

template <class T>
Json json_of(const std::optional<T>& value) {
  if constexpr (std::is_floating_point_v<T>) {
    return value ? json_of(*value) : Json(nullptr);
  } else {
    return value ? Json(*value) : Json(nullptr);
  }
}

inline Json json_of(const Percentiles& percentiles) {
  return {{"median", json_of(percentiles.median)}, {"p95", json_of(percentiles.p95)}};
}

inline std::optional<double> number(const Json& json) {
  return json.is_null() ? std::nullopt : std::optional<double>(json.get<double>());
}

inline std::optional<std::int64_t> integer(const Json& json) {
  return json.is_null() ? std::nullopt : std::optional<std::int64_t>(json.get<std::int64_t>());
}

inline Percentiles percentiles(const Json& json) {
  return {.median = number(json.at("median")), .p95 = number(json.at("p95"))};
}

/// Eye movements in the block of the gaze.
[[nodiscard]] Json json_of(const EyeMovementScore& score);
/// Throws as detector_score().
[[nodiscard]] EyeMovementScore eye_movement_score(const Json& json);
/// A detector's block of metrics.json.
[[nodiscard]] Json json_of(const DetectorScore& score);
/// Throws Json::exception for a key that is missing or of a wrong type.
[[nodiscard]] DetectorScore detector_score(const Json& json);

}  // namespace saccade::metrics_json
