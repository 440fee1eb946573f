#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace saccade {

/// A file that a run reads, and its contents.
struct FileDigest {
  std::string key;     ///< of the configuration that names it: "detectors.mine.python"
  std::string path;    ///< as the run opened it
  std::string digest;  ///< digest_of_file()
  bool mentioned =
      false;  ///< found in the text of another file or in arguments, so that it may be an output as well

  friend bool operator==(const FileDigest&, const FileDigest&) = default;
};

/// 16 hexadecimal digits that stand for the bytes (FNV-1a, 64 bits).
[[nodiscard]] std::string digest(std::string_view bytes);

/// The digest of a file's bytes; of a folder, that of the names and bytes of the files in it. "unreadable" where they
/// cannot be read.
[[nodiscard]] std::string digest_of_file(const std::filesystem::path& path);

}  // namespace saccade
