#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "config/scenario.h"
#include "loop/loop.h"
#include "sim/sim_robot.h"

namespace cv {
class Mat;
}

namespace saccade {

class RunScores;
class VideoComposer;

/// Writes the images of a simulated run (`output.pictures`, `output.video`): stills of eyes, scene and Hough spaces into
/// frames/, and video.mp4.
class RunPictures final : public LoopObserver {
 public:
  /// The folder exists. All others outlive it; `scores` are updated before it.
  RunPictures(std::filesystem::path folder, const Scenario& scenario, SimRobot& robot, const Loop& loop,
              const RunScores& scores);
  ~RunPictures() override;

  void on_tick(const Tick& tick) override;
  /// Closes the video under its final name.
  void commit();
  /// Wall-clock time spent here, s.
  [[nodiscard]] double wall_s() const { return wall_s_; }

 private:
  void keep_recent_events(const Tick& tick);
  void draw(const Tick& tick);
  void write_stills(const Tick& tick, const cv::Mat& grey, const cv::Mat& scene) const;
  void write_hough_spaces(std::int64_t t_us) const;
  void add_video_frame(const Tick& tick, const cv::Mat& grey, const cv::Mat& scene);

  std::filesystem::path folder_;
  const Scenario& scenario_;
  SimRobot& robot_;
  const Loop& loop_;
  const RunScores& scores_;
  std::vector<std::int64_t> still_times_us_;
  std::unique_ptr<VideoComposer> video_;
  std::vector<Event> recent_events_;
  double wall_s_ = 0.0;
};

}  // namespace saccade
