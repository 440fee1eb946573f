#include "images/decoded_sequence.h"

#include <cmath>

#include "core/error.h"
#include "emulator/srgb.h"
#include "images/image_kinds.h"
#include "recording/codec.h"

namespace saccade {
namespace {

std::string kind_of(const cv::Mat& image) {
  const char* const depths[] = {
      "8 bit", "8 bit with a sign", "16 bit", "16 bit with a sign", "32 bit", "float", "float", "half float"};
  return depths[image.depth()];
}

bool is_float(const cv::Mat& image) { return image.depth() == CV_32F || image.depth() == CV_64F; }

template <class Value, class Linear>
void convert_rows(const cv::Mat& image, std::vector<float>& luminance, Linear linear) {
  float* out = luminance.data();
  for (int row = 0; row < image.rows; ++row) {
    const Value* in = image.ptr<Value>(row);
    if (image.channels() == 1) {
      for (int i = 0; i < image.cols; ++i) *out++ = static_cast<float>(linear(in[i]));
      continue;
    }
    for (int i = 0; i < image.cols; ++i, in += 3) {  // blue, green, red
      *out++ = static_cast<float>(0.0722 * linear(in[0]) + 0.7152 * linear(in[1]) + 0.2126 * linear(in[2]));
    }
  }
}

}  // namespace

void Luminance::convert(const cv::Mat& image, const std::string& name, std::vector<float>& luminance) {
  const int channels = image.channels();
  if (channels != 1 && channels != 3) {
    throw InputError(name, std::to_string(channels) + " channels", "one of grey or three of colour");
  }
  luminance.resize(image.total());
  switch (image.depth()) {
    case CV_8U:
      prepare(256);
      convert_rows<std::uint8_t>(image, luminance, [this](std::uint8_t v) { return linear_[v]; });
      return;
    case CV_16U:
      prepare(65536);
      convert_rows<std::uint16_t>(image, luminance, [this](std::uint16_t v) { return linear_[v]; });
      return;
    case CV_32F:
      convert_rows<float>(image, luminance, [](float v) { return v; });
      return;
    case CV_64F:
      convert_rows<double>(image, luminance, [](double v) { return v; });
      return;
    default:
      throw InputError(name, kind_of(image) + " numbers", "8 or 16 bit without a sign, or float");
  }
}

void Luminance::prepare(std::size_t levels) {
  if (linear_.size() == levels) return;
  linear_.resize(levels);
  for (std::size_t i = 0; i < levels; ++i) {
    linear_[i] = white_ * linear_from_srgb(static_cast<double>(i) / static_cast<double>(levels - 1));
  }
}

bool DecodedSequence::read(std::vector<float>& luminance) {
  if (ahead_.empty() && !decode(ahead_)) return false;
  begin(next_);
  const std::string name = name_of(next_);
  const ImageSize size{ahead_.cols, ahead_.rows};
  if (size != info_.size) {
    throw InputError(name, "an image of " + text_of(size), text_of(info_.size) + ", as the first one");
  }
  if (kind_of(ahead_) != kind_) throw InputError(name, kind_of(ahead_), kind_ + ", as the first one");
  luminance_.convert(ahead_, name, luminance);
  ahead_.release();
  ++next_;
  return true;
}

void DecodedSequence::look_ahead() {
  if (!decode(ahead_)) return;
  info_.size = {ahead_.cols, ahead_.rows};
  info_.linear = is_float(ahead_);
  kind_ = kind_of(ahead_);
  if (!is_possible_image(info_.size)) {
    throw InputError(name_of(0), "an image of " + text_of(info_.size), possible_image_sizes());
  }
}

}  // namespace saccade
