#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "evaluation/image_codecs/image_codecs.h"

namespace cv {
class VideoWriter;
}

namespace saccade {

/// What saccade-image-codecs.so offers, under the name codec_library_symbol. The number in the name changes with the members.
struct CodecLibrary {
  cv::Mat (*decode)(std::string_view bytes, DecodedAs form);
  /// The caller owns what these two return.
  cv::VideoCapture* (*read_video)(const std::string& path);
  cv::VideoWriter* (*write_video)(const std::string& path, std::string_view codec, double images_hz,
                                  const cv::Size& size);
  std::vector<std::int64_t> (*video_times)(const std::string& path);
};

inline constexpr const char* codec_library_file = "saccade-image-codecs.so";
inline constexpr const char* codec_library_symbol = "saccade_image_codecs_2";

}  // namespace saccade
