#pragma once

#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "config/scenario.h"
#include "recording/file_digest.h"

namespace saccade {

/// Lists the files that runs read while they run, with their digests: those that keys of the configuration name, the programs
/// of external detectors and controllers, and the files that these name (mentioned_files()). Files whose values became part
/// of the configuration, such as `calibration.file`, are not listed. Reads each file once, so that it serves many
/// configurations at one time.
class InputFiles {
 public:
  [[nodiscard]] std::vector<FileDigest> of(const Scenario& scenario);
  [[nodiscard]] std::vector<FileDigest> of(const NamedDetectors& detectors);

  using Describe = std::function<void(FieldVisitor&)>;
  [[nodiscard]] std::vector<FileDigest> of(const Describe& describe_keys);

 private:
  class Lister;
  [[nodiscard]] const std::string& digest_of(const std::string& path);
  [[nodiscard]] const std::vector<std::string>& mentioned_in(const std::string& path,
                                                             const std::string& folder);

  std::map<std::string, std::string> digests_;
  std::map<std::pair<std::string, std::string>, std::vector<std::string>> mentioned_;
};

}  // namespace saccade
