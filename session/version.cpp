#include "session/version.h"

namespace saccade {

std::string_view version() { return SACCADE_VERSION; }
std::string_view commit() { return SACCADE_COMMIT; }
std::string_view release_date() { return SACCADE_DATE; }
std::string_view least_yarp_version() { return SACCADE_YARP_MINIMUM; }

std::string version_line() {
  return "# saccade " + std::string(version()) + " (" + std::string(commit()) + ")";
}

}  // namespace saccade
