#include "evaluation/report/film.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <vector>

#include "core/error.h"
#include "core/time_stamp.h"
#include "evaluation/report/overlay.h"
#include "evaluation/report/run_images.h"

namespace saccade {
namespace {

constexpr std::size_t read_block_events = 1 << 16;
/// An image is drawn with the largest whole scale with which it fits into a square of so many pixels, at least 1.
constexpr int panel_px = 640;
constexpr int caption_height = 48;
constexpr double longest_s = 4e12;

struct Extent {
  std::optional<std::int64_t> first_us;
  std::int64_t last_us = 0;
  ImageSize size{1, 1};
  std::array<bool, 2> cameras{};  ///< those with events
};

Extent extent_of(EventReader& reader) {
  Extent extent;
  std::vector<Event> block;
  while (reader.read(block, read_block_events) > 0) {
    if (!extent.first_us) extent.first_us = extent.last_us = block.front().t_us;
    for (const Event& event : block) {
      extent.last_us = std::max(extent.last_us, event.t_us);
      extent.size = {std::max(extent.size.width, event.x + 1), std::max(extent.size.height, event.y + 1)};
      extent.cameras[event.camera] = true;
    }
    block.clear();
  }
  return extent;
}

int even(int number) { return number + number % 2; }  // H.264 stores colours for 2 x 2 pixels

/// Draws and writes one image after the other.
class Film {
 public:
  Film(const RunData& run, const FilmConfig& config, bool two_cameras, const std::filesystem::path& out)
      : run_(run),
        config_(config),
        two_cameras_(two_cameras),
        window_us_(std::llround(config.window_ms * 1e3)),
        scale_(
            std::max(1, std::min(panel_px / run.metrics.image.width, panel_px / run.metrics.image.height))),
        panel_{even(run.metrics.image.width * scale_), even(run.metrics.image.height * scale_)},
        file_(out, {std::max(panel_px, panel_.width * (two_cameras ? 2 : 1)), panel_.height + caption_height},
              VideoComposer::frame_hz) {}

  [[nodiscard]] std::int64_t window_us() const { return window_us_; }
  [[nodiscard]] std::int64_t images() const { return file_.images(); }
  void commit() { file_.commit(); }

  /// `zero_us`: the instant 0 of the line below the images.
  void add(const Frame& frame, std::int64_t zero_us) {
    const AnnotatedImage left = left_image(run_, frame, window_us_, CircleNames::yes);
    cv::Mat picture(file_.size().height, file_.size().width, CV_8UC3, cv::Scalar(24, 24, 24));
    const auto place = [&](const AnnotatedImage& image, int x) {
      fit_into(draw_image(image, scale_), panel_.width, panel_.height)
          .copyTo(picture({x, 0, panel_.width, panel_.height}));
    };
    place(left, two_cameras_ ? 0 : (picture.cols - panel_.width) / 2);
    if (two_cameras_) {
      place(other_image(frame), panel_.width);
      cv::line(picture, {panel_.width, 0}, {panel_.width, panel_.height - 1}, {24, 24, 24}, 2);
    }
    cv::putText(picture,
                fmt::format("{}   t {:.4f} s   {} events in {:g} ms", config_.name,
                            static_cast<double>(frame.t_us - zero_us) * 1e-6,
                            frame.events.size() + frame.other_events.size(), config_.window_ms),
                {12, panel_.height + 30}, cv::FONT_HERSHEY_SIMPLEX, 0.5, {240, 240, 240}, 1, cv::LINE_AA);
    file_.add(picture);
  }

 private:
  [[nodiscard]] AnnotatedImage other_image(const Frame& frame) const {
    if (run_.metrics.right_eye) return right_image(run_, frame);
    AnnotatedImage image;
    image.size = run_.metrics.image;
    image.events = frame.other_events;
    return image;
  }

  const RunData& run_;
  const FilmConfig& config_;
  bool two_cameras_;
  std::int64_t window_us_;
  int scale_;
  ImageSize panel_;
  VideoFile file_;
};

/// The time `seconds` after the first event.
std::int64_t after(std::int64_t first_us, double seconds) {
  return saturated_sum(first_us, std::llround(std::min(seconds, longest_s) * 1e6));
}

}  // namespace

FilmResult write_film(const FormatRegistry& formats, const std::filesystem::path& events,
                      const EventReadOptions& options, RunData run, const std::filesystem::path& out,
                      const FilmConfig& config, const std::function<void(double)>& progress) {
  const auto first_reader = open_event_file(formats, events, options);
  Extent extent = extent_of(*first_reader);
  if (!extent.first_us) throw InputError(events.string(), "no event", "a recording with events");
  const std::int64_t begin_us = after(*extent.first_us, config.from_s);
  const std::int64_t end_us = std::min(extent.last_us, after(*extent.first_us, config.until_s));
  if (begin_us > end_us)
    throw InputError("--from", fmt::format("{:g}", config.from_s),
                     fmt::format("less than {:g}, the recording's last event and --until",
                                 static_cast<double>(end_us - *extent.first_us) * 1e-6));
  FilmResult result;
  result.guess = first_reader->guess();
  if (run.metrics.image.pixels() <= 0) {
    run.metrics.image = first_reader->image_size().value_or(extent.size);
    if (!first_reader->image_size())
      result.guess = fmt::format("the image size {}x{}, from the events; --size sets it", extent.size.width,
                                 extent.size.height);
  }

  const std::int64_t zero_us = run.metrics.duration_s > 0.0 ? run.metrics.start_us : *extent.first_us;
  const bool both = extent.cameras[0] && extent.cameras[1];
  Film film(run, config, both || run.metrics.right_eye, out);
  const std::uint8_t only = extent.cameras[1] ? 1 : 0;
  const std::uint8_t camera = run.metrics.events_camera.value_or(both ? 0 : only);
  const double step_us = 1e6 / VideoComposer::frame_hz * config.speed;
  const auto time_of = [&](std::int64_t image) {
    return begin_us + std::llround(static_cast<double>(image) * step_us);
  };
  Frame frame{};
  frame.t_us = begin_us;
  const auto draw_until = [&](std::int64_t t_us) {
    for (; frame.t_us < t_us && frame.t_us <= end_us; frame.t_us = time_of(film.images())) {
      const auto is_old = [&](const Event& e) { return e.t_us <= frame.t_us - film.window_us(); };
      std::erase_if(frame.events, is_old);
      std::erase_if(frame.other_events, is_old);
      film.add(frame, zero_us);
      if (progress)
        progress(static_cast<double>(frame.t_us - begin_us) /
                 static_cast<double>(std::max<std::int64_t>(1, end_us - begin_us)));
    }
  };
  const auto reader = open_event_file(formats, events, options);
  for (std::vector<Event> block; reader->read(block, read_block_events) > 0; block.clear()) {
    for (const Event& event : block) {
      draw_until(event.t_us);
      if (event.t_us > frame.t_us - film.window_us())
        (event.camera == camera ? frame.events : frame.other_events).push_back(event);
    }
    if (frame.t_us > end_us) break;
  }
  draw_until(end_us + 1);
  film.commit();
  result.images = film.images();
  return result;
}

}  // namespace saccade
