#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string_view>
#include <vector>

#include "evaluation/image_codecs/image_codecs.h"

namespace saccade {

/// PNG and JPEG by libpng and libjpeg, with OpenCV's settings: the same bytes and the same images as cv::imencode and
/// cv::imdecode, without their 140 libraries. `format` is png or jpeg; `image` has 1, 3 (BGR) or 4 channels (PNG alone) of
/// 8 or, for PNG, 16 bits. Empty where it cannot be encoded.
[[nodiscard]] std::vector<unsigned char> encoded_png_or_jpeg(std::string_view format, const cv::Mat& image,
                                                             PngSize png);
/// Empty where `bytes` are no whole image; none where they are neither PNG nor JPEG, or JPEG of four inks.
[[nodiscard]] std::optional<cv::Mat> decoded_png_or_jpeg(std::string_view bytes, DecodedAs form);

}  // namespace saccade
