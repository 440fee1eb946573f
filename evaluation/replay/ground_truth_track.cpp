#include <array>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "evaluation/image_codecs/image_codecs.h"
#include "evaluation/replay/foxglove_track.h"
#include "evaluation/report/html.h"
#include "recording/array_rows.h"
#include "recording/run_file_names.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// Distinct colours without an order: steps of the golden ratio around the circle of hues. 0 is black.
cv::Vec3b colour_of_number(std::uint8_t number) {
  if (number == 0) return {0, 0, 0};
  constexpr double golden = 0.618033988749895;
  constexpr std::array<double, 2> values = {230.0, 160.0};
  const double hue = 6.0 * std::fmod(number * golden, 1.0);
  const double value = values.at(number % values.size());
  const auto channel = [&](double shift) {
    const double k = std::fmod(shift + hue, 6.0);
    const double share = std::clamp(std::min(k, 4.0 - k), 0.0, 1.0);
    return cv::saturate_cast<std::uint8_t>(value * (1.0 - 0.75 * share));
  };
  return {channel(1.0), channel(3.0), channel(5.0)};  // OpenCV: BGR
}

/// An array of images and the topic for it.
struct ImageArray {
  enum class Kind { grey_numbers, grey, numbers, magnitude, objects };
  const char* array;
  const char* topic;
  Kind kind;
  ArrayType type;
};
constexpr std::array image_arrays = {
    ImageArray{"image", "luminance", ImageArray::Kind::grey_numbers, ArrayType::f32},
    ImageArray{"frame", "frame", ImageArray::Kind::grey, ArrayType::u8},
    ImageArray{"depth_m", "depth_m", ImageArray::Kind::numbers, ArrayType::f32},
    ImageArray{"flow_px_s", "flow_px_s", ImageArray::Kind::magnitude, ArrayType::f32},
    ImageArray{"segmentation", "segmentation", ImageArray::Kind::objects, ArrayType::u8},
};

class GroundTruthTrack final : public FoxgloveTrack {
 public:
  GroundTruthTrack(fs::path file, FoxgloveWriter& writer) : file_(std::move(file)), writer_(writer) {
    times_ = open_array(file_, "t_us");
    if (!times_ || times_->type() != ArrayType::i64 || times_->shape().size() != 1)
      throw InputError(file_.string(), "no array t_us of whole numbers", "ground truth of saccade");
    for (const char* const side : {"left", "right"}) {
      for (const ImageArray& kind : image_arrays) add(side, kind);
    }
    go_on();
  }

  std::optional<std::int64_t> next_us() override { return next_us_; }
  void write() override {
    for (Source& source : sources_) {
      if (!source.rows->next(row_)) fail_short(source.name);
      writer_.write(source.topic, *next_us_, message(source));
    }
    go_on();
  }

 private:
  struct Source {
    std::string name;
    std::string frame;
    ImageArray::Kind kind;
    std::unique_ptr<ArrayRows> rows;
    std::size_t topic;
    int height;
    int width;
  };

  void add(const std::string& side, const ImageArray& kind) {
    const std::string name = side + "/" + kind.array;
    std::unique_ptr<ArrayRows> rows = open_array(file_, name);
    if (!rows) return;
    const std::vector<std::size_t>& shape = rows->shape();
    constexpr std::size_t longest = 1 << 15;
    const bool has_pairs = kind.kind == ImageArray::Kind::magnitude;
    if (rows->type() != kind.type || shape.size() != (has_pairs ? 4U : 3U) || (has_pairs && shape[3] != 2) ||
        shape[1] > longest || shape[2] > longest || shape[1] * shape[2] == 0)
      throw InputError(file_.string(), "the array " + name + " of another shape or type",
                       "ground truth of saccade");
    if (shape[0] < times_->shape()[0]) fail_short(name);
    const bool is_raw = has_pairs || kind.kind == ImageArray::Kind::numbers;
    const std::size_t topic = writer_.add("/" + side + "/ground_truth/" + kind.topic,
                                          is_raw ? "foxglove.RawImage" : "foxglove.CompressedImage");
    const auto height = static_cast<int>(shape[1]);
    const auto width = static_cast<int>(shape[2]);
    sources_.push_back({name, side + "_camera", kind.kind, std::move(rows), topic, height, width});
  }

  void go_on() {
    next_us_.reset();
    if (!times_->next(row_)) return;
    std::int64_t t_us = 0;
    std::memcpy(&t_us, row_.data(), sizeof t_us);
    if (t_us < last_us_) throw InputError(file_.string(), "times that go back", "ground truth of saccade");
    next_us_ = last_us_ = t_us;
  }

  Json message(const Source& source) {
    using Kind = ImageArray::Kind;
    const bool is_bytes = source.kind == Kind::grey || source.kind == Kind::objects;
    const int type = is_bytes ? CV_8UC1 : source.kind == Kind::magnitude ? CV_32FC2 : CV_32FC1;
    const cv::Mat image(source.height, source.width, type, row_.data());
    cv::Mat drawn = image;
    if (source.kind == Kind::grey_numbers) image.convertTo(drawn, CV_8U);
    if (source.kind == Kind::magnitude) {
      drawn.create(image.size(), CV_32FC1);
      for (int y = 0; y < image.rows; ++y) {
        for (int x = 0; x < image.cols; ++x) {
          const cv::Vec2f& flow = image.at<cv::Vec2f>(y, x);
          drawn.at<float>(y, x) = std::hypot(flow[0], flow[1]);
        }
      }
    }
    if (source.kind == Kind::objects) {
      drawn = cv::Mat(image.size(), CV_8UC3);
      for (int y = 0; y < image.rows; ++y) {
        for (int x = 0; x < image.cols; ++x)
          drawn.at<cv::Vec3b>(y, x) = colour_of_number(image.at<std::uint8_t>(y, x));
      }
    }
    return drawn.depth() == CV_32F ? foxglove_numbers(*next_us_, source.frame, drawn)
                                   : foxglove_png(*next_us_, source.frame, drawn);
  }

  [[noreturn]] void fail_short(const std::string& name) const {
    throw InputError(file_.string(), "fewer rows in the array " + name + " than in t_us",
                     "ground truth of saccade");
  }

  fs::path file_;
  FoxgloveWriter& writer_;
  std::unique_ptr<ArrayRows> times_;
  std::vector<Source> sources_;
  std::optional<std::int64_t> next_us_;
  std::int64_t last_us_ = 0;
  std::string row_;
};

}  // namespace

Json foxglove_png(std::int64_t t_us, const std::string& frame, const cv::Mat& image) {
  return {{"timestamp", foxglove_time(t_us)},
          {"frame_id", frame},
          {"data", base64(encoded_image("png", image))},
          {"format", "png"}};
}

Json foxglove_numbers(std::int64_t t_us, const std::string& frame, const cv::Mat& image) {
  SACCADE_CHECK(image.type() == CV_32FC1 && image.isContinuous());
  const std::vector<unsigned char> bytes(image.data, image.data + image.total() * image.elemSize());
  return {{"timestamp", foxglove_time(t_us)},
          {"frame_id", frame},
          {"width", image.cols},
          {"height", image.rows},
          {"encoding", "32FC1"},
          {"step", image.cols * 4},
          {"data", base64(bytes)}};
}

std::unique_ptr<FoxgloveTrack> ground_truth_track(const fs::path& run_folder, FoxgloveWriter& writer) {
  for (const char* const name : {run_file::ground_truth_hdf5, run_file::ground_truth_npz}) {
    if (fs::exists(run_folder / name)) return std::make_unique<GroundTruthTrack>(run_folder / name, writer);
  }
  return nullptr;
}

}  // namespace saccade
