#include "images/image_sequence.h"

#include "core/error.h"
#include "images/image_kinds.h"
#include "recording/codec.h"

namespace saccade {

namespace fs = std::filesystem;

std::string lower_case_extension(const fs::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return extension;
}

std::unique_ptr<ImageSequence> open_image_sequence(const fs::path& path, double white,
                                                   std::span<const ImageTime> named) {
  std::error_code error;
  if (!fs::exists(path, error)) {
    throw InputError(path.string(), "no such file or folder",
                     "a folder of images, a NumPy array (.npy) or a video");
  }
  if (fs::is_directory(path, error)) return open_image_folder(path, white, named);
  if (!named.empty()) {
    throw InputError(named.front().place, "the name " + printable(named.front().name),
                     "times alone, for " + path.string() + " is no folder");
  }
  if (lower_case_extension(path) == ".npy") return open_npy(path);
  return open_video(path, white);
}

}  // namespace saccade
