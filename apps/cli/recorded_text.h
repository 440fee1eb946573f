#pragma once

#include <string>
#include <vector>

#include "recording/recorded_folder.h"

namespace saccade {

/// A line about each file: its name, rows and times, the gap before it, and what is lost.
[[nodiscard]] std::string text_of(const std::vector<RecordedFile>& files,
                                  const std::filesystem::path& folder);
/// The same as JSON.
[[nodiscard]] std::string json_of(const std::vector<RecordedFile>& files,
                                  const std::filesystem::path& folder);
/// "12 bytes from byte 3456 on are lost: what was found and expected".
[[nodiscard]] std::string text_of(const TornEnd& torn);

}  // namespace saccade
