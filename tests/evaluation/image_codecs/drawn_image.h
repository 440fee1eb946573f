#pragma once

#include <opencv2/core.hpp>
#include <string_view>
#include <vector>

namespace saccade {

/// Grey steps and a coloured square.
inline cv::Mat drawn(int width, int height) {
  cv::Mat image(height, width, CV_8UC3);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x)
      image.at<cv::Vec3b>(y, x) = cv::Vec3b::all(static_cast<unsigned char>(4 * x));
  }
  image(cv::Rect(width / 4, height / 4, width / 2, height / 2)).setTo(cv::Scalar(10, 120, 240));
  return image;
}

inline std::string_view text_of(const std::vector<unsigned char>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace saccade
