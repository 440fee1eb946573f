#pragma once

#include <filesystem>
#include <string>

#include "config/sections.h"
#include "loop/latency.h"

namespace saccade {

/// The keys of a scenario's section `latency`. With kind `model` each detector has a section of its own, and so has the
/// frame camera if `frame_camera`; their values start from the file that the key `file` names, there under the
/// detector's name or that of its preset.
void describe_latency(FieldVisitor& v, LatencyConfig& latency, const NamedDetectors& detectors,
                      bool frame_camera);

/// Reads processing times: the block `latency` of a file that `saccade fit-latency` wrote. Throws InputError with everything
/// that is wrong.
[[nodiscard]] LatencyConfig read_latency(const std::filesystem::path& path);
/// The processing times as such a file.
[[nodiscard]] std::string latency_yaml(LatencyConfig latency);

}  // namespace saccade
