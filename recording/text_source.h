#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "core/error.h"
#include "recording/input_file.h"
#include "recording/unpacked_part.h"
#include "recording/zip_members.h"

namespace saccade {

/// The bytes of a text: those of a file, or of the only text (.txt, .csv) in a ZIP file. Has the reading members of InputFile.
class TextSource {
 public:
  /// Throws InputError for a ZIP file without a text, or with several.
  explicit TextSource(InputFile file);

  /// As InputFile::peek(), at most 64 KiB ahead in a ZIP file. Where that is cut off or broken, whole lines before that place
  /// come first, and then the error is thrown.
  [[nodiscard]] std::string_view peek(std::size_t wanted) {
    return part_ ? peek_in_zip(wanted) : file_->peek(wanted);
  }
  void skip(std::size_t count) {
    if (part_) {
      part_->skip(count);
    } else {
      file_->skip(count);
    }
  }
  [[nodiscard]] std::uint64_t offset() const {
    return file_->offset();
  }                                                         ///< in the file, of the first byte not unpacked
  [[nodiscard]] std::string name() const { return name_; }  ///< for messages
  [[nodiscard]] bool is_in_zip() const { return part_ != nullptr; }

 private:
  std::string_view peek_in_zip(std::size_t wanted);

  std::unique_ptr<InputFile> file_;
  std::string name_;
  ZipMember member_;
  std::unique_ptr<UnpackedPart> part_;  ///< none: the file itself is the text
  std::optional<InputError> broken_;    ///< what is wrong with the file behind the text
  std::optional<InputError> failure_;   ///< why the text cannot be read further
};

}  // namespace saccade
