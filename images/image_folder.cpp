#include <stdlib.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <iterator>
#include <string_view>

#include "core/error.h"
#include "evaluation/image_codecs/image_codecs.h"
#include "images/decoded_sequence.h"
#include "images/image_kinds.h"
#include "recording/codec.h"
#include "recording/number_text.h"

namespace saccade {
namespace {

constexpr std::array<std::string_view, 9> image_extensions = {".bmp", ".exr", ".jpeg", ".jpg", ".pgm",
                                                              ".png", ".ppm", ".tif",  ".tiff"};

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// Numbers in names by their value: f2 before f10.
bool natural_less(const std::string& a, const std::string& b) {
  std::size_t i = 0;
  std::size_t k = 0;
  while (i < a.size() && k < b.size()) {
    if (!is_digit(a[i]) || !is_digit(b[k])) {
      if (a[i] != b[k]) return a[i] < b[k];
      ++i;
      ++k;
      continue;
    }
    const auto number = [](const std::string& text, std::size_t& at) {
      const std::size_t end = std::min(text.find_first_not_of("0123456789", at), text.size());
      const std::size_t begin = std::min(text.find_first_not_of('0', at), end);
      at = end;
      return std::string_view(text).substr(begin, end - begin);
    };
    const std::string_view first = number(a, i);
    const std::string_view second = number(b, k);
    if (first.size() != second.size()) return first.size() < second.size();
    if (first != second) return first < second;
  }
  if ((i < a.size()) != (k < b.size())) return k < b.size();
  return a < b;
}

std::string bytes_of(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  std::string bytes((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
  if (!stream.is_open() || stream.bad()) {
    std::error_code error;
    throw InputError(path.string(),
                     std::filesystem::exists(path, error) ? "a file that cannot be read" : "no such file",
                     "an image");
  }
  return bytes;
}

/// What OpenCV takes in silence: a JPEG that is cut off becomes grey where it ends, and the levels of a PGM or
/// PPM whose white is neither 255 nor 65535 stay as they are.
void check_bytes(std::string_view bytes, const std::string& name) {
  if (bytes.starts_with("\xff\xd8")) {
    const std::size_t scan = bytes.rfind("\xff\xda");
    if (scan == std::string_view::npos || bytes.find("\xff\xd9", scan) == std::string_view::npos) {
      throw InputError(name, "a JPEG that is cut off", "a whole one");
    }
  }
  if (bytes.size() > 2 && bytes[0] == 'P' &&
      std::string_view("2356").find(bytes[1]) != std::string_view::npos) {
    std::size_t at = 2;
    std::string_view white;
    for (int field = 0; field < 3; ++field) {
      while (at < bytes.size() && (is_blank(bytes[at]) || bytes[at] == '\n' || bytes[at] == '#')) {
        at = bytes[at] == '#' ? std::min(bytes.find('\n', at), bytes.size()) : at + 1;
      }
      const std::size_t end = std::min(bytes.find_first_not_of("0123456789", at), bytes.size());
      white = bytes.substr(at, end - at);
      at = end;
    }
    if (white != "255" && white != "65535") {
      throw InputError(name, "white at " + printable(white), "white at 255 or 65535");
    }
  }
}

class FolderSequence final : public DecodedSequence {
 public:
  FolderSequence(std::filesystem::path folder, double white, std::span<const ImageTime> named)
      : DecodedSequence(white), folder_(std::move(folder)) {
    // OpenCV reads EXR only with this variable, which it reads when the first such file is opened.
    setenv("OPENCV_IO_ENABLE_OPENEXR", "1", 1);
    if (named.empty()) {
      list_images();
    } else {
      for (const ImageTime& image : named) {
        if (!std::filesystem::is_regular_file(folder_ / image.name)) {
          throw InputError(image.place, printable(image.name), "the name of a file in " + folder_.string());
        }
        names_.push_back(image.name);
      }
    }
    info_.count = std::ssize(names_);
    look_ahead();
  }

  [[nodiscard]] std::string name_of(std::int64_t image) const override {
    return (folder_ / names_[static_cast<std::size_t>(image)]).string() + ", image " + std::to_string(image);
  }

 protected:
  bool decode(cv::Mat& image) override {
    if (decoded_ == names_.size()) return false;
    const std::string bytes = bytes_of(folder_ / names_[decoded_]);
    const std::string name = name_of(static_cast<std::int64_t>(decoded_));
    check_bytes(bytes, name);
    ++decoded_;
    try {
      image = decoded_image(bytes, DecodedAs::stored);
    } catch (const cv::Exception&) {
      image.release();
    }
    if (image.empty()) throw InputError(name, "a file that cannot be decoded", "a whole image");
    return true;
  }

 private:
  void list_images() {
    std::error_code error;
    for (std::filesystem::directory_iterator it(folder_, error), end; it != end; it.increment(error)) {
      if (error) break;
      const std::string name = it->path().filename().string();
      const bool known =
          std::ranges::find(image_extensions, lower_case_extension(name)) != image_extensions.end();
      if (known && !name.starts_with('.') && it->is_regular_file()) {
        names_.push_back(name);
      } else {
        ++info_.skipped_files;
      }
    }
    std::ranges::sort(names_, natural_less);
    if (error) throw InputError(folder_.string(), "a folder that cannot be read", "a folder of images");
    if (!names_.empty()) return;
    std::string kinds;
    for (const std::string_view extension : image_extensions) kinds += " " + std::string(extension);
    throw InputError(folder_.string(),
                     info_.skipped_files == 0
                         ? "an empty folder"
                         : "none among " + std::to_string(info_.skipped_files) + " files",
                     "images:" + kinds);
  }

  std::filesystem::path folder_;
  std::vector<std::string> names_;
  std::size_t decoded_ = 0;
};

}  // namespace

std::unique_ptr<ImageSequence> open_image_folder(const std::filesystem::path& path, double white,
                                                 std::span<const ImageTime> named) {
  return std::make_unique<FolderSequence>(path, white, named);
}

}  // namespace saccade
