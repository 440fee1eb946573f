#pragma once

#include <filesystem>
#include <map>
#include <string>

namespace saccade {

/// The configuration of a run but its seed, key by key: the lines of the resolved scenario.yaml (or detectors.yaml) in its
/// folder, "ball.diameter_m" -> "0.095"; the version that made it under "version"; and the files that it read, under their
/// key with "contents" added: "ball.trajectory.file.contents" -> "mocap_ball.csv 8c7dd922ad47494f". Two runs with the same keys and
/// different seeds are repetitions of one experiment. Keys that change no score are left out: `seed`, `description`,
/// `output`, `expect`, `run.threads`.
using ResolvedKeys = std::map<std::string, std::string>;

/// Of a text as YamlWriter writes it: one key a line, nested by indentation, lists in the lines after their key.
[[nodiscard]] ResolvedKeys resolved_keys(const std::string& yaml);

/// Of a run folder; empty where it has neither file.
[[nodiscard]] ResolvedKeys read_resolved_keys(const std::filesystem::path& run_folder);

/// The keys of `b` that differ from `a`, as "key=value, ..."; at most three, then "...".
[[nodiscard]] std::string difference_text(const ResolvedKeys& a, const ResolvedKeys& b);

/// Those keys that are not about detectors and gaze, as one text.
[[nodiscard]] std::string world_text(const ResolvedKeys& keys);

}  // namespace saccade
