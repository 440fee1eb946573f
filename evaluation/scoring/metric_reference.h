#pragma once

#include <span>
#include <string_view>

namespace saccade {

/// The definition of one key of metrics.json, for `saccade keys metrics` and the tables of docs/.
struct MetricRow {
  std::string_view path;  ///< "detectors.NAME.lag_ms"; NAME stands for that of a detector
  std::string_view type;  ///< "number", "text" ...; "block" where the keys below the path have no rows
  std::string_view doc;
};

/// Every key of metrics.json; a row covers everything below its path.
[[nodiscard]] std::span<const MetricRow> metric_reference();

}  // namespace saccade
