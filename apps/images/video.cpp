#include <cmath>
#include <opencv2/videoio.hpp>

#include "apps/images/decoded_sequence.h"
#include "apps/images/image_kinds.h"
#include "core/error.h"
#include "evaluation/image_codecs/image_codecs.h"

namespace saccade::inline v0_1 {
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
  }

  [[nodiscard]] std::string name_of(std::int64_t image) const override {
    return name_ + ", image " + std::to_string(image);
  }

 protected:
  bool decode(cv::Mat& image) override {
    try {
      return video_->read(image);
    } catch (const cv::Exception&) {
      throw InputError(name_of(next()), "an image that cannot be decoded", "a whole video");
    }
  }

 private:
  std::string name_;
  std::unique_ptr<cv::VideoCapture> video_;
};

}  // namespace

std::unique_ptr<ImageSequence> open_video(const std::filesystem::path& path, double white) {
  return std::make_unique<VideoSequence>(path, white);
}

}  // namespace saccade::inline v0_1
