#pragma once

#include <map>
#include <optional>
#include <string>

#include "core/event.h"
#include "recording/input_file.h"

namespace saccade {

/// The header of Prophesee's files: lines `% key value`, up to `% end` or the first line of another form. Keys are in
/// lower case here.
class PropheseeHeader {
 public:
  /// Reads the header and leaves the file after it. Throws InputError for one without its end, or of more than 64 KiB.
  explicit PropheseeHeader(InputFile& file);

  /// The value of a key, empty where there is none.
  [[nodiscard]] std::string value(const std::string& key) const;
  /// The sensor's size as `% geometry 1280x720`, `% format EVT3;height=720;width=1280`, or `% width` and `% height`;
  /// none without such a line, or where its numbers are no size.
  [[nodiscard]] std::optional<ImageSize> image_size() const;

 private:
  std::map<std::string, std::string> values_;
};

}  // namespace saccade
