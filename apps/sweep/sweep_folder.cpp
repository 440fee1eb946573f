#include "apps/sweep/sweep_folder.h"

#include <fstream>
#include <iterator>
#include <system_error>

#include "recording/file_lock.h"

namespace saccade {

namespace fs = std::filesystem;

namespace {

/// Of a metrics.json, which says so near its beginning; false for a file that is not there.
bool is_interrupted(const fs::path& metrics) {
  constexpr std::size_t enough = 4096;
  std::string begin(enough, '\0');
  std::ifstream file(metrics, std::ios::binary);
  file.read(begin.data(), enough);
  return begin.find("\"interrupted\": true") != std::string::npos;
}

}  // namespace

std::string text_of_file(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

bool SweepFolder::has_result(const std::string& id) const { return finished(id).has_value(); }

std::optional<fs::file_time_type> SweepFolder::finished(const std::string& id) const {
  for (const char* name : {"metrics.json", "failure.txt"}) {
    std::error_code error;
    if (is_interrupted(run(id) / name)) continue;
    const fs::file_time_type time = fs::last_write_time(run(id) / name, error);
    if (!error) return time;
  }
  return std::nullopt;
}

bool SweepFolder::has_worst_report(const std::string& id) const {
  return fs::exists(worst(id) / "report.html") && !is_interrupted(worst(id) / "metrics.json");
}

bool SweepFolder::is_running(const std::string& id) const { return is_locked(run(id) / "log.txt"); }

}  // namespace saccade
