#pragma once

#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>

#include "evaluation/image_codecs/image_codecs.h"

namespace saccade {

/// A video that the program ffmpeg of PATH encodes, as H.264 where it can, else as what it prefers for the container; images
/// go to it through a socket. For an installation without a video library. Throws RunError where ffmpeg cannot be started;
/// write() and close() throw RunError with ffmpeg's message where it fails.
[[nodiscard]] std::unique_ptr<VideoOutput> write_video_by_ffmpeg(const std::filesystem::path& path,
                                                                 double images_hz, const cv::Size& size);

}  // namespace saccade
