#include "recording/yarp_log_info.h"

#include <algorithm>
#include <fstream>

#include "core/error.h"
#include "recording/codec.h"
#include "recording/number_text.h"

namespace saccade {

std::filesystem::path yarp_info_file(const std::filesystem::path& log) {
  const std::string name = log.filename().string();
  if (name == "data.log" || name == "binaryevents.log") return log.parent_path() / "info.log";
  return log.parent_path() / (log.stem().string() + ".info.log");
}

std::string yarp_info(const std::filesystem::path& log, std::string_view key) {
  constexpr int most_lines = 100;
  std::ifstream in(yarp_info_file(log));
  std::string line;
  for (int i = 0; i < most_lines && std::getline(in, line); ++i) {
    if (!line.starts_with(key)) continue;
    line.erase(0, key.size());
    line.erase(std::min(line.find(';'), line.size()));
    return line;
  }
  return {};
}

std::int64_t yarp_info_number(const std::filesystem::path& log, std::string_view key, std::int64_t largest,
                              std::int64_t otherwise) {
  const std::string text = yarp_info(log, key);
  if (text.empty()) return otherwise;
  std::int64_t number = 0;
  if (!parse_number(text, number) || number > largest || number < -largest) {
    throw InputError(yarp_info_file(log).string(), std::string(key) + printable(text),
                     "a whole number of at most " + std::to_string(largest));
  }
  return number;
}

std::optional<ImageSize> yarp_info_size(const std::filesystem::path& log) {
  const std::string text = yarp_info(log, yarp_size_key);
  if (text.empty()) return std::nullopt;
  const std::optional<ImageSize> size = parse_size(text);
  if (!size || size->width < 1 || size->height < 1) {
    throw InputError(yarp_info_file(log).string(), std::string(yarp_size_key) + printable(text),
                     "WIDTHxHEIGHT");
  }
  return size;
}

}  // namespace saccade
