#include <limits>

#include "core/config.h"
#include "evaluation/scoring/metrics_json.h"

namespace saccade::metrics_json {
namespace {

Json block_of(const std::optional<RejectedEvents>& rejected) {
  if (!rejected) return nullptr;
  return {{"outside_image", rejected->outside_image}, {"back_in_time", rejected->back_in_time}};
}

Json block_of(const std::optional<StreamingScore>& score) {
  if (!score) return nullptr;
  Json json = {{"average_precision", json_of(score->average_precision)},
               {"precision", json_of(score->precision)},
               {"recall", json_of(score->recall)},
               {"latency_ms",
                {{"median", json_of(score->latency_median_ms)}, {"p99", json_of(score->latency_p99_ms)}}}};
  if (!score->exact) json["approximate"] = true;
  return json;
}

std::optional<StreamingScore> streaming_score(const Json& json) {
  if (json.is_null()) return std::nullopt;
  return StreamingScore{.average_precision = number(json.at("average_precision")),
                        .precision = number(json.at("precision")),
                        .recall = number(json.at("recall")),
                        .latency_median_ms = number(json.at("latency_ms").at("median")),
                        .latency_p99_ms = number(json.at("latency_ms").at("p99")),
                        .exact = !json.value("approximate", false)};
}

Json block_of(const std::optional<Nees>& nees) {
  if (!nees) return nullptr;
  return {{"count", nees->count}, {"share", nees->below_bound}, {"median", nees->median}};
}

std::optional<Nees> nees(const Json& json) {
  if (json.is_null()) return std::nullopt;
  return Nees{json.at("count").get<std::int64_t>(), json.at("share").get<double>(),
              json.at("median").get<double>()};
}

Json block_of(const std::optional<Reliability>& reliability) {
  if (!reliability) return nullptr;
  Json bins = Json::array();
  for (std::size_t i = 0; i < reliability->size(); ++i) {
    const ReliabilityBin& bin = (*reliability)[i];
    bins.push_back({{"from", static_cast<double>(i) / static_cast<double>(reliability_bins)},
                    {"count", bin.observations},
                    {"inliers", bin.inliers},
                    {"inlier_share", json_of(bin.inlier_share())},
                    {"mean_score", bin.observations > 0 ? json_of(bin.mean_score) : Json(nullptr)}});
  }
  return bins;
}

std::optional<Reliability> reliability(const Json& json) {
  if (json.is_null()) return std::nullopt;
  Reliability bins;
  for (std::size_t i = 0; i < bins.size(); ++i) {
    const Json& bin = json.at(i);
    bins[i].observations = bin.at("count").get<std::int64_t>();
    bins[i].inliers = bin.at("inliers").get<std::int64_t>();
    bins[i].mean_score = number(bin.at("mean_score")).value_or(0.0);
  }
  return bins;
}

}  // namespace

Json json_of(const DetectorScore& score) {
  Json at_recall = Json::object();
  for (std::size_t i = 0; i < reported_recalls.size(); ++i) {
    at_recall[text_of(reported_recalls[i])] = json_of(score.precision_at_recall[i]);
  }
  Json curve = Json::array();
  for (const CurvePoint& point : score.pr_curve) {
    curve.push_back(
        {{"threshold", point.threshold}, {"precision", point.precision}, {"recall", point.recall}});
  }
  const auto at_threshold = [&](std::int64_t count) {
    return std::isnan(score.threshold) ? Json(nullptr) : Json(count);
  };
  Json json = {
      {"average_precision", json_of(score.average_precision)},
      {"precision_at_recall", std::move(at_recall)},
      {"pr_curve", std::move(curve)},
      {"chances", score.chances},
      {"threshold", json_of(score.threshold)},
      {"precision", json_of(score.precision)},
      {"recall", json_of(score.recall)},
      {"detection_rate_hz", {{"mean", json_of(score.mean_rate_hz)}, {"peak", json_of(score.peak_rate_hz)}}},
      {"position_error_px", json_of(score.position_error_px)},
      {"radius_error_px", json_of(score.radius_error_px)},
      {"lag_ms", json_of(score.lag_ms)},
      {"us_per_event", json_of(score.us_per_event)},
      {"alarm_ratio", json_of(score.alarm_ratio)},
      {"alarms_per_min", json_of(score.alarms_per_min)},
      {"streaming", block_of(score.streaming)},
      {"nees", block_of(score.nees)},
      {"reliability", block_of(score.reliability)},
      {"observations", at_threshold(score.observations)},
      {"inliers", at_threshold(score.inliers)},
      {"rejected_events", block_of(score.rejected_events)}};
  if (!score.exact) json["approximate"] = true;
  if (!score.failure.empty()) json["failure"] = score.failure;
  if (score.clutter) {
    json["clutter_in_window"] = {{"detected", json_of(score.clutter->in_window_detected)},
                                 {"missed", json_of(score.clutter->in_window_missed)}};
    json["clutter_per_detection"] = json_of(score.clutter->per_detection);
  }
  return json;
}

DetectorScore detector_score(const Json& json) {
  DetectorScore score;
  score.average_precision = number(json.at("average_precision"));
  for (std::size_t i = 0; i < reported_recalls.size(); ++i) {
    score.precision_at_recall[i] = number(json.at("precision_at_recall").at(text_of(reported_recalls[i])));
  }
  for (const Json& point : json.at("pr_curve")) {
    score.pr_curve.push_back({.threshold = point.at("threshold").get<double>(),
                              .precision = point.at("precision").get<double>(),
                              .recall = point.at("recall").get<double>()});
  }
  score.chances = json.at("chances").get<std::int64_t>();
  score.threshold = number(json.at("threshold")).value_or(std::numeric_limits<double>::quiet_NaN());
  score.observations = integer(json.at("observations")).value_or(0);
  score.inliers = integer(json.at("inliers")).value_or(0);
  score.precision = number(json.at("precision"));
  score.recall = number(json.at("recall"));
  score.mean_rate_hz = number(json.at("detection_rate_hz").at("mean"));
  score.peak_rate_hz = number(json.at("detection_rate_hz").at("peak"));
  score.position_error_px = percentiles(json.at("position_error_px"));
  score.radius_error_px = percentiles(json.at("radius_error_px"));
  score.lag_ms = number(json.at("lag_ms"));
  score.us_per_event = number(json.at("us_per_event"));
  score.alarm_ratio = number(json.value("alarm_ratio", Json(nullptr)));
  score.alarms_per_min = number(json.value("alarms_per_min", Json(nullptr)));
  score.streaming = streaming_score(json.value("streaming", Json(nullptr)));
  score.nees = nees(json.value("nees", Json(nullptr)));
  score.reliability = reliability(json.value("reliability", Json(nullptr)));
  score.exact = !json.value("approximate", false);
  score.failure = json.value("failure", std::string());
  if (const auto rejected = json.find("rejected_events"); rejected != json.end() && !rejected->is_null()) {
    score.rejected_events = {.outside_image = rejected->at("outside_image").get<std::int64_t>(),
                             .back_in_time = rejected->at("back_in_time").get<std::int64_t>()};
  }
  if (const auto window = json.find("clutter_in_window"); window != json.end()) {
    score.clutter = {.in_window_detected = number(window->at("detected")),
                     .in_window_missed = number(window->at("missed")),
                     .per_detection = number(json.at("clutter_per_detection"))};
  }
  return score;
}

}  // namespace saccade::metrics_json
