#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "apps/view/snapshot.h"
#include "apps/view/wall_clock.h"

namespace saccade {

class VideoFile;

/// Screenshots and videos of the window, and settings that the user saves. Where a file cannot be written, message() reports it and the window continues.
class Capture {
 public:
  /// `name`: of what is shown, in the names of the files. `folder`: is made when needed.
  Capture(std::string name, std::filesystem::path folder);
  ~Capture();
  Capture(const Capture&) = delete;
  Capture& operator=(const Capture&) = delete;

  /// Takes a screenshot as soon as the window shows a snapshot that includes this request.
  void request_screenshot(std::uint64_t request) { screenshot_of_ = request; }
  /// Starts a video of the window with that size, or ends the one that is being written.
  void toggle_video(ImageSize window);
  /// Ends a video that is being written.
  void finish();
  /// Writes a text into the folder, as NAME + `suffix` + ".yaml" with a number where that exists.
  void save_yaml(const std::string& suffix, const std::string& yaml);

  /// Whether add() needs the next image of the window. `up_to_date`: every panel shows the snapshot.
  [[nodiscard]] bool needs_image(const Snapshot& snapshot, bool up_to_date) const {
    return filming() || screenshot_due(snapshot, up_to_date);
  }
  /// `shown`: what the window shows, BGR.
  void add(const cv::Mat& shown, const Snapshot& snapshot, bool up_to_date);

  [[nodiscard]] bool filming() const { return video_ != nullptr; }
  /// What was written last or failed, for 4 s; then empty.
  [[nodiscard]] std::string message() const;

 private:
  [[nodiscard]] bool screenshot_due(const Snapshot& snapshot, bool up_to_date) const {
    return screenshot_of_ && up_to_date && !snapshot.seeking && snapshot.request >= *screenshot_of_;
  }
  [[nodiscard]] std::filesystem::path free_name(const std::string& stem, const char* extension) const;
  void save_screenshot(const cv::Mat& shown, const Snapshot& snapshot);
  void film(const cv::Mat& shown);
  void show(std::string message);
  template <class Write>
  void try_to(Write write);

  std::string name_;
  std::filesystem::path folder_;
  std::optional<std::uint64_t> screenshot_of_;  // the number of a request
  std::unique_ptr<VideoFile> video_;
  WallClock::time_point video_begin_;
  std::string message_;
  WallClock::time_point message_time_;
};

}  // namespace saccade
