// saccade-image-codecs.so: all that links OpenCV's imgcodecs and videoio, and ffmpeg's libavformat, which videoio uses.
#include "evaluation/image_codecs/codec_library.h"

extern "C" {
#include <libavformat/avformat.h>
}

#include <algorithm>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>

namespace saccade {
namespace {

int flags_of(DecodedAs form) {
  switch (form) {
    case DecodedAs::stored:
      return cv::IMREAD_ANYDEPTH | cv::IMREAD_ANYCOLOR;
    case DecodedAs::grey:
      return cv::IMREAD_GRAYSCALE;
    case DecodedAs::colour:
      break;
  }
  return cv::IMREAD_COLOR;
}

cv::Mat decode(std::string_view bytes, DecodedAs form) {
  if (bytes.empty()) return {};
  // OpenCV takes no constant data; imdecode only reads it.
  const cv::Mat view(1, static_cast<int>(bytes.size()), CV_8U, const_cast<char*>(bytes.data()));
  return cv::imdecode(view, flags_of(form));
}

cv::VideoCapture* new_capture(const std::string& path) { return new cv::VideoCapture(path, cv::CAP_FFMPEG); }

cv::VideoWriter* new_writer(const std::string& path, std::string_view codec, double images_hz,
                            const cv::Size& size) {
  return new cv::VideoWriter(
      path, cv::CAP_FFMPEG, cv::VideoWriter::fourcc(codec[0], codec[1], codec[2], codec[3]), images_hz, size);
}

/// The times of the packets of the video, in the order in which their images are shown, from the start of the video.
std::vector<std::int64_t> packet_times(const std::string& path) {
  AVFormatContext* opened = nullptr;
  if (avformat_open_input(&opened, path.c_str(), nullptr, nullptr) < 0) return {};
  const auto close = [](AVFormatContext* context) { avformat_close_input(&context); };
  const std::unique_ptr<AVFormatContext, decltype(close)> file(opened, close);
  if (avformat_find_stream_info(opened, nullptr) < 0) return {};
  const int index = av_find_best_stream(opened, AVMEDIA_TYPE_VIDEO, -1, -1, nullptr, 0);
  if (index < 0) return {};
  const AVStream& stream = *opened->streams[index];
  const auto free_packet = [](AVPacket* packet) { av_packet_free(&packet); };
  const std::unique_ptr<AVPacket, decltype(free_packet)> packet(av_packet_alloc(), free_packet);
  std::vector<std::int64_t> times;
  for (; av_read_frame(opened, packet.get()) >= 0; av_packet_unref(packet.get())) {
    if (packet->stream_index != index || (packet->flags & AV_PKT_FLAG_DISCARD) != 0 || packet->size == 0)
      continue;
    if (packet->pts == AV_NOPTS_VALUE) return {};
    const std::int64_t start = stream.start_time == AV_NOPTS_VALUE ? 0 : stream.start_time;
    times.push_back(av_rescale_q(packet->pts - start, stream.time_base, AVRational{1, 1'000'000}));
  }
  std::sort(times.begin(), times.end());
  return times;
}

}  // namespace
}  // namespace saccade

extern "C" {
extern const saccade::CodecLibrary saccade_image_codecs_2;
const saccade::CodecLibrary saccade_image_codecs_2{&saccade::decode, &saccade::new_capture,
                                                   &saccade::new_writer, &saccade::packet_times};
}
