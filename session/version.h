#pragma once

#include <string>
#include <string_view>

namespace saccade {

/// The program's version, "0.1.0".
[[nodiscard]] std::string_view version();
/// The commit it was built from, "9b6774e", with "-dirty" where files differed from it; "unknown" outside a checkout.
[[nodiscard]] std::string_view commit();

/// The day of the release, "2026-11-26", of CITATION.cff.
[[nodiscard]] std::string_view release_date();

/// The oldest YARP that the backend `yarp` is built with, "3.9".
[[nodiscard]] std::string_view least_yarp_version();

/// "# saccade VERSION (COMMIT)", the first line of resolved files in a run folder.
[[nodiscard]] std::string version_line();

}  // namespace saccade
