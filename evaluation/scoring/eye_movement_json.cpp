#include <utility>

#include "evaluation/scoring/metrics_json.h"

namespace saccade::metrics_json {
namespace {

Json transfer_json(const std::optional<Transfer>& transfer) {
  if (!transfer) return nullptr;
  return {{"frequency_hz", json_of(transfer->frequency_hz)},
          {"gain", json_of(transfer->gain)},
          {"phase_deg", json_of(transfer->phase_deg)}};
}

std::optional<Transfer> transfer_of(const Json& json) {
  if (json.is_null()) return std::nullopt;
  return Transfer{json.at("frequency_hz").get<double>(), json.at("gain").get<double>(),
                  json.at("phase_deg").get<double>()};
}

}  // namespace

Json json_of(const EyeMovementScore& score) {
  Json steps = Json::array();
  for (const GazeStep& step : score.steps) {
    steps.push_back({{"size_deg", json_of(step.size_deg)},
                     {"latency_ms", json_of(step.latency_ms)},
                     {"peak_deg_s", json_of(step.peak_deg_s)},
                     {"settled_ms", json_of(step.settled_ms)}});
  }
  Json ramps = nullptr;
  if (score.ramps) {
    ramps = {{"count", score.ramps->count},
             {"ball_deg_s", json_of(score.ramps->ball_deg_s)},
             {"gain", json_of(score.ramps->gain)},
             {"lag_deg", json_of(score.ramps->lag_deg)}};
  }
  return {{"pursuit", transfer_json(score.pursuit)},
          {"pursuit_lag_ms", json_of(score.pursuit_lag_ms)},
          {"stabilisation", transfer_json(score.stabilisation)},
          {"slip_reduction", json_of(score.slip_reduction)},
          {"error_deg", json_of(score.error_deg)},
          {"image_motion_px_s",
           {{"median", json_of(score.image_median_px_s)}, {"p90", json_of(score.image_p90_px_s)}}},
          {"steps", std::move(steps)},
          {"ramps", std::move(ramps)},
          {"main_sequence",
           {{"saccades", score.saccades},
            {"slope_per_s", json_of(score.main_sequence_per_s)},
            {"offset_deg_s", json_of(score.main_sequence_offset_deg_s)}}}};
}

EyeMovementScore eye_movement_score(const Json& json) {
  EyeMovementScore score;
  score.pursuit = transfer_of(json.at("pursuit"));
  score.pursuit_lag_ms = number(json.at("pursuit_lag_ms"));
  score.stabilisation = transfer_of(json.at("stabilisation"));
  score.slip_reduction = number(json.at("slip_reduction"));
  score.error_deg = percentiles(json.at("error_deg"));
  score.image_median_px_s = number(json.at("image_motion_px_s").at("median"));
  score.image_p90_px_s = number(json.at("image_motion_px_s").at("p90"));
  for (const Json& step : json.at("steps")) {
    score.steps.push_back({step.at("size_deg").get<double>(), number(step.at("latency_ms")),
                           step.at("peak_deg_s").get<double>(), number(step.at("settled_ms"))});
  }
  const Json& ramps = json.at("ramps");
  if (!ramps.is_null()) {
    score.ramps = GazeRamps{ramps.at("count").get<std::int64_t>(), ramps.at("ball_deg_s").get<double>(),
                            ramps.at("gain").get<double>(), ramps.at("lag_deg").get<double>()};
  }
  const Json& sequence = json.at("main_sequence");
  score.saccades = sequence.at("saccades").get<std::int64_t>();
  score.main_sequence_per_s = number(sequence.at("slope_per_s"));
  score.main_sequence_offset_deg_s = number(sequence.at("offset_deg_s"));
  return score;
}

}  // namespace saccade::metrics_json
