#include "session/log_file.h"

#include <fmt/format.h>

namespace saccade {

LogFile::LogFile(const std::filesystem::path& file, std::function<void(const std::string&)> echo)
    : file_(file), echo_(std::move(echo)) {}

void LogFile::write(std::int64_t t_us, const std::string& text) {
  const std::string line = fmt::format("{:10.3f} s  {}", static_cast<double>(t_us) * 1e-6, text);
  file_.write(line + "\n");
  echo_(line);
}

}  // namespace saccade
