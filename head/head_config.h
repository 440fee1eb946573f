#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/config.h"
#include "head/head_description.h"
#include "head/head_model.h"

namespace saccade {

/// Limits of a joint that are narrower than the head's own.
struct NarrowedLimits {
  double min_deg = -360.0;
  double max_deg = 360.0;
};

/// Keys: min_deg, max_deg.
void describe(FieldVisitor& v, NarrowedLimits& limits);

enum class HeadKind { icub, ergocub, described };
constexpr auto words_of(HeadKind) {
  return std::to_array<Word<HeadKind>>(
      {{HeadKind::icub, "icub"}, {HeadKind::ergocub, "ergocub"}, {HeadKind::described, "described"}});
}

/// Which head a robot has.
struct HeadConfig {
  HeadKind model = HeadKind::icub;
  std::string version = "2";    ///< of the iCub, as written: 2.1 and 2.10 differ; or of the ergoCub
  HeadDescription description;  ///< of a described head
  /// Of single joints; where they are wider than the head's own limits those hold.
  std::vector<std::pair<std::string, NarrowedLimits>> limits;
};

/// Keys: model, version (icub, ergocub), those of HeadDescription (described), limits.
void describe(FieldVisitor& v, HeadConfig& config);

/// The head of a configuration. Throws InputError for a configuration out of range.
[[nodiscard]] std::shared_ptr<const HeadModel> head_model(const HeadConfig& config);

/// The same, or the default head where the configuration is out of range.
[[nodiscard]] std::shared_ptr<const HeadModel> valid_head(const HeadConfig& config);

}  // namespace saccade
