#pragma once

#include <span>
#include <string>

#include "apps/view/view_settings.h"
#include "core/detector_registry.h"

namespace saccade {

/// The detector outside of this program that a user names: FILE.py:CLASS, or the path of a program. It is enabled; its name is
/// that of the class or of the program, with a number where one of `others` has it. Throws InputError for a file that does not
/// exist, and where `detectors` has no such detectors.
[[nodiscard]] ViewDetector own_detector(const DetectorRegistry& detectors, const std::string& text,
                                        std::span<const ViewDetector> others);

}  // namespace saccade
