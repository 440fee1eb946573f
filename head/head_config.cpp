#include "head/head_config.h"

#include <algorithm>

#include "core/units.h"
#include "head/ergocub_heads.h"

namespace saccade {
namespace {

std::shared_ptr<const HeadModel> unlimited(const HeadConfig& config) {
  if (config.model == HeadKind::described) return described_head(config.description);
  if (config.model == HeadKind::ergocub) return described_head(ergocub_description(config.version));
  return config.version == "2" ? default_head() : icub_head(config.version);
}

}  // namespace

void describe(FieldVisitor& v, NarrowedLimits& limits) {
  v.real("min_deg", limits.min_deg, {-360.0, 360.0}, "lowest position");
  v.real("max_deg", limits.max_deg, {-360.0, 360.0}, "highest position");
}

void describe(FieldVisitor& v, HeadConfig& config) {
  v.choice("model", config.model, "the robot's head; described: by the keys below, or by a file");
  const bool ergocub = config.model == HeadKind::ergocub;
  if (v.fills_defaults() && ergocub && std::ranges::count(ergocub_versions(), config.version) == 0)
    config.version = ergocub_versions().front();
  v.when(config.model != HeadKind::described, "model: icub or ergocub", [&] {
    v.choice("version", config.version, ergocub ? ergocub_versions() : icub_versions(),
             "version of the iCub's head, as written: 2.1 is not 2.10; of the ergoCub's: SN001 (default) or "
             "SN003");
  });
  v.when(config.model == HeadKind::described, "model: described", [&] { describe(v, config.description); });
  v.named_sections("limits", config.limits,
                   "limits of joints that are narrower than the head's, by the joint's name",
                   "limits of a joint");
}

std::shared_ptr<const HeadModel> head_model(const HeadConfig& config) {
  check_config("head", config);
  const std::shared_ptr<const HeadModel> head = unlimited(config);
  if (config.limits.empty()) return head;
  const auto narrowed = std::make_shared<HeadModel>(*head);
  std::vector<Problem> problems;
  std::string names;
  for (const HeadJoint& joint : head->joints) names += (names.empty() ? "" : ", ") + joint.name;
  for (const auto& [name, limits] : config.limits) {
    const std::string place = "head.limits." + name;
    const auto joint = std::ranges::find(narrowed->joints, name, &HeadJoint::name);
    if (joint == narrowed->joints.end()) {
      problems.push_back({place, name, "a joint of the head: " + names});
      continue;
    }
    joint->min_rad = std::max(joint->min_rad, limits.min_deg * rad_per_deg);
    joint->max_rad = std::min(joint->max_rad, limits.max_deg * rad_per_deg);
    if (!(joint->min_rad < joint->max_rad)) {
      problems.push_back({place, text_of(limits.min_deg) + " to " + text_of(limits.max_deg) + " deg",
                          "a part of the head's own range"});
    }
  }
  if (!problems.empty()) throw InputError(problems);
  return narrowed;
}

std::shared_ptr<const HeadModel> valid_head(const HeadConfig& config) {
  try {
    return head_model(config);
  } catch (const InputError&) {
    return default_head();
  }
}

}  // namespace saccade
