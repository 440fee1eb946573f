#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "images/image_sequence.h"

namespace saccade {

/// Converts decoded images to luminance, as ImageSequence describes.
class Luminance {
 public:
  /// `white`: luminance of white in integer images.
  explicit Luminance(double white) : white_(white) {}

  /// Throws InputError for numbers or channels that cannot be converted.
  void convert(const cv::Mat& image, const std::string& name, std::vector<float>& luminance);

 private:
  void prepare(std::size_t levels);

  double white_;
  std::vector<double> linear_;  ///< by grey level
};

/// A sequence of images that OpenCV decodes.
class DecodedSequence : public ImageSequence {
 public:
  bool read(std::vector<float>& luminance) final;

 protected:
  explicit DecodedSequence(double white) : luminance_(white) {}

  /// Decodes the first image and fills info_ from it; constructors call it.
  void look_ahead();
  /// The next image; false after the last one.
  virtual bool decode(cv::Mat& image) = 0;
  /// The image decoded last is given out now.
  virtual void begin(std::int64_t image) { static_cast<void>(image); }
  [[nodiscard]] std::int64_t next() const { return next_; }

 private:
  Luminance luminance_;
  cv::Mat ahead_;  ///< the first image until it is read
  std::string kind_;
  std::int64_t next_ = 0;
};

}  // namespace saccade
