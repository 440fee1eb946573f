#include <algorithm>
#include <cmath>
#include <opencv2/videoio.hpp>

#include "core/error.h"
#include "evaluation/image_codecs/image_codecs.h"
#include "images/decoded_sequence.h"
#include "images/image_kinds.h"

namespace saccade {
namespace {

class VideoSequence final : public DecodedSequence {
 public:
  VideoSequence(const std::filesystem::path& path, double white)
      : DecodedSequence(white), name_(path.string()) {
    try {
      video_ = read_video(path);
      if (video_->isOpened()) look_ahead();
    } catch (const cv::Exception&) {
      video_.reset();
    }
    if (!video_ || !video_->isOpened() || !info_.size.contains(0, 0)) {
      throw InputError(name_, "a file that cannot be decoded",
                       "a video, a NumPy array (.npy) or a folder of images");
    }
    const double count = video_->get(cv::CAP_PROP_FRAME_COUNT);
    if (count >= 1.0 && count < 1e12) info_.count = std::llround(count);
    const double rate = video_->get(cv::CAP_PROP_FPS);
    if (rate > 0.0 && std::isfinite(rate)) info_.images_per_s = rate;
    times_us_ = video_times(path);
    if (!times_us_.empty()) info_.count = std::ssize(times_us_);
    if (is_regular()) times_us_.clear();
  }

  [[nodiscard]] std::optional<std::int64_t> time_us() const override { return time_us_; }

  [[nodiscard]] std::string name_of(std::int64_t image) const override {
    return name_ + ", image " + std::to_string(image);
  }

 protected:
  bool decode(cv::Mat& image) override {
    try {
      if (!video_->read(image)) return false;
      shown_us_ = std::llround(1e3 * video_->get(cv::CAP_PROP_POS_MSEC));
      return true;
    } catch (const cv::Exception&) {
      throw InputError(name_of(next()), "an image that cannot be decoded", "a whole video");
    }
  }

  void begin(std::int64_t image) override {
    if (times_us_.empty()) return;
    // The decoder gives the last images, those that it has held back, without their times.
    const auto next_time = time_us_ ? std::ranges::upper_bound(times_us_, *time_us_) : times_us_.begin();
    if (shown_us_ != 0 || image == 0) {
      time_us_ = shown_us_;
    } else if (next_time != times_us_.end()) {
      time_us_ = *next_time;
    } else {
      throw InputError(name_of(image), "an image without a time",
                       "one in the container, or --fps or --timestamps");
    }
  }

 private:
  /// Whether all images are shown at the video's rate, as far as a container's whole milliseconds tell.
  [[nodiscard]] bool is_regular() const {
    if (!info_.images_per_s) return false;
    for (std::size_t k = 0; k < times_us_.size(); ++k) {
      constexpr double rounding_us = 600.0;
      const double expected_us = 1e6 * static_cast<double>(k) / *info_.images_per_s;
      if (std::abs(static_cast<double>(times_us_[k] - times_us_[0]) - expected_us) > rounding_us)
        return false;
    }
    return true;
  }

  std::string name_;
  std::unique_ptr<cv::VideoCapture> video_;
  std::vector<std::int64_t> times_us_;   ///< of all images; empty: at the video's rate
  std::int64_t shown_us_ = 0;            ///< of the image decoded last; 0: the first one, or unknown
  std::optional<std::int64_t> time_us_;  ///< of the image read last
};

}  // namespace

std::unique_ptr<ImageSequence> open_video(const std::filesystem::path& path, double white) {
  return std::make_unique<VideoSequence>(path, white);
}

}  // namespace saccade
