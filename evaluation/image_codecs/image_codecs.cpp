#include "evaluation/image_codecs/image_codecs.h"

#include <dlfcn.h>

#include <opencv2/videoio.hpp>

#include "core/error.h"
#include "evaluation/image_codecs/codec_library.h"
#include "recording/helper_reader.h"

namespace saccade {
namespace {

const CodecLibrary& library() {
  // Loaded once: the system's loader returns the same library from then on.
  void* const handle = ::dlopen(find_helper(codec_library_file).c_str(), RTLD_NOW | RTLD_LOCAL);
  const void* const symbol = handle != nullptr ? ::dlsym(handle, codec_library_symbol) : nullptr;
  if (symbol == nullptr) throw RunError(std::string("images cannot be read or written: ") + ::dlerror());
  return *static_cast<const CodecLibrary*>(symbol);
}

/// A library of images alone makes none.
template <class Video>
std::unique_ptr<Video> video_of(Video* video) {
  if (video == nullptr)
    throw RunError(
        "videos are not read or written: this installation of saccade has no video library; Debian's package "
        "has");
  return std::unique_ptr<Video>(video);
}

}  // namespace

std::vector<unsigned char> encoded_image(std::string_view format, const cv::Mat& image, PngSize png) {
  std::vector<unsigned char> bytes;
  if (!library().encode(format, image, png, bytes))
    throw RunError("an image cannot be encoded as " + std::string(format));
  return bytes;
}

cv::Mat decoded_image(std::string_view bytes, DecodedAs form) { return library().decode(bytes, form); }

cv::Mat read_image(const std::filesystem::path& path, DecodedAs form) {
  return library().read(path.string(), form);
}

std::unique_ptr<cv::VideoCapture> read_video(const std::filesystem::path& path) {
  return video_of(library().read_video(path.string()));
}

std::vector<std::int64_t> video_times(const std::filesystem::path& path) {
  return library().video_times(path.string());
}

std::unique_ptr<cv::VideoWriter> write_video(const std::filesystem::path& path, std::string_view codec,
                                             double images_hz, const cv::Size& size) {
  SACCADE_CHECK(codec.size() == 4);
  return video_of(library().write_video(path.string(), codec, images_hz, size));
}

}  // namespace saccade
