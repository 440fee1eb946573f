#include "apps/sweep/metrics_numbers.h"

#include <nlohmann/json.hpp>
#include <set>

#include "core/error.h"

namespace saccade {
namespace {

using Json = nlohmann::ordered_json;

void collect(const Json& json, const std::string& path, MetricsNumbers& numbers) {
  static const std::set<std::string> no_results = {"schema",
                                                   "seed",
                                                   "camera",
                                                   "calibration",
                                                   "settings",
                                                   "start_us",
                                                   "joint_limits_rad",
                                                   "gaze.window",
                                                   "gaze.gate",
                                                   "gaze.controller",
                                                   "gaze.acquire_within_deg"};
  static const std::set<std::string> clock_keys = {"wall_s", "real_time_factor", "us_per_event"};
  for (const auto& [key, value] : json.items()) {
    const std::string name = path.empty() ? key : path + "." + key;
    if (no_results.contains(key) || no_results.contains(name)) continue;
    if (key == "pr_curve") {
      Json points = Json::array();
      for (const Json& point : value)
        points.push_back({point.at("threshold"), point.at("precision"), point.at("recall")});
      const std::size_t detector = path.find('.');
      const std::string prefix = path.starts_with("right_eye.") ? "right eye: " : "";
      numbers.curves.emplace_back(prefix + path.substr(prefix.empty() ? detector + 1 : path.rfind('.') + 1),
                                  points.dump());
    } else if (value.is_object()) {
      collect(value, name, numbers);
    } else if (value.is_number() || (value.is_null() && name != "gaze")) {
      const auto number = value.is_null() ? std::nullopt : std::optional(value.get<double>());
      (clock_keys.contains(key) ? numbers.times : numbers.metrics).emplace_back(name, number);
    }
  }
}

}  // namespace

MetricsNumbers metrics_numbers(std::string_view text, const std::string& place) {
  MetricsNumbers numbers;
  try {
    const Json json = Json::parse(text);
    numbers.scenario = json.at("scenario").get<std::string>();
    if (const auto seed = json.find("seed"); seed != json.end() && !seed->is_null())
      numbers.seed = seed->dump();
    numbers.interrupted = json.value("interrupted", false);
    if (const auto settings = json.find("settings"); settings != json.end()) {
      for (const auto& [key, value] : settings->items())
        numbers.settings += (numbers.settings.empty() ? "" : ", ") + key + "=" + value.get<std::string>();
    }
    collect(json, "", numbers);
  } catch (const Json::exception& error) {
    throw RunError(place + ": not the metrics of a run: " + error.what());
  }
  return numbers;
}

}  // namespace saccade
