#include "apps/view/capture.h"

#include <fmt/format.h>

#include <cmath>
#include <span>
#include <vector>

#include "evaluation/image_codecs/image_codecs.h"
#include "evaluation/report/overlay.h"
#include "recording/output_file.h"

namespace saccade {
namespace {

constexpr int video_hz = 25;
constexpr double message_s = 4.0;

}  // namespace

Capture::Capture(std::string name, std::filesystem::path folder)
    : name_(std::move(name)), folder_(std::move(folder)) {}
Capture::~Capture() = default;

template <class Write>
void Capture::try_to(Write write) {
  try {
    write();
  } catch (const std::exception& error) {
    show(error.what());
  }
}

void Capture::show(std::string message) {
  message_ = std::move(message);
  message_time_ = WallClock::now();
}

std::string Capture::message() const {
  return seconds_between(message_time_, WallClock::now()) < message_s ? message_ : "";
}

std::filesystem::path Capture::free_name(const std::string& stem, const char* extension) const {
  std::filesystem::create_directories(folder_);
  std::filesystem::path path = folder_ / (stem + extension);
  for (int i = 2; std::filesystem::exists(path); ++i)
    path = folder_ / fmt::format("{}_{}{}", stem, i, extension);
  return path;
}

void Capture::add(const cv::Mat& shown, const Snapshot& snapshot, bool up_to_date) {
  if (screenshot_due(snapshot, up_to_date)) {
    screenshot_of_.reset();
    try_to([&] { save_screenshot(shown, snapshot); });
  }
  if (filming()) try_to([&] { film(shown); });
}

void Capture::save_screenshot(const cv::Mat& shown, const Snapshot& snapshot) {
  const std::vector<unsigned char> png = encoded_image("png", shown);
  const auto path =
      free_name(fmt::format("{}_{:06}ms", name_, (snapshot.now_us - snapshot.start_us) / 1000), ".png");
  OutputFile file(path);
  file.write(std::as_bytes(std::span(png)));
  file.commit();
  show("written: " + path.string());
}

void Capture::save_yaml(const std::string& suffix, const std::string& yaml) {
  try_to([&] {
    const auto path = free_name(name_ + suffix, ".yaml");
    write_file(path, yaml);
    show("written: " + path.string());
  });
}

void Capture::toggle_video(ImageSize window) {
  if (filming()) return finish();
  try_to([&] {
    // H.264 needs even sides.
    video_ = std::make_unique<VideoFile>(free_name(name_, ".mp4"),
                                         ImageSize{window.width / 2 * 2, window.height / 2 * 2}, video_hz);
    video_begin_ = WallClock::now();
  });
}

void Capture::finish() {
  const std::unique_ptr<VideoFile> video = std::move(video_);
  if (!video) return;
  try_to([&] {
    if (video->images() > 0) video->commit();
    show("written: " + video->path().string());
  });
}

void Capture::film(const cv::Mat& shown) {
  const ImageSize size = video_->size();
  if (shown.cols < size.width || shown.rows < size.height) return finish();  // the window has become smaller
  const auto due = std::llround(seconds_between(video_begin_, WallClock::now()) * video_hz);
  const cv::Mat part = shown({0, 0, size.width, size.height}).clone();
  while (video_->images() <= due) video_->add(part);
}

}  // namespace saccade
