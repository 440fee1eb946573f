#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "evaluation/replay/foxglove_file.h"
#include "evaluation/replay/foxglove_writer.h"
#include "evaluation/scoring/metrics.h"
#include "recording/event_file.h"
#include "recording/run_files.h"

namespace saccade {

/// A source of messages: tracks are written together in the order of their times. Its constructor adds its topics.
class FoxgloveTrack {
 public:
  FoxgloveTrack() = default;
  FoxgloveTrack(const FoxgloveTrack&) = delete;
  FoxgloveTrack& operator=(const FoxgloveTrack&) = delete;
  virtual ~FoxgloveTrack() = default;

  /// Time of its next messages, which does not go back; none at the end.
  [[nodiscard]] virtual std::optional<std::int64_t> next_us() = 0;
  /// Writes the messages of next_us() and goes on.
  virtual void write() = 0;
};

/// The instants of the images of a run, which are whole ms: number k shows the events after that of k - 1 up to its own.
class ImageInstants {
 public:
  ImageInstants(const Metrics& metrics, double images_hz)
      : start_us_(metrics.start_us),
        end_ms_(
            std::max<std::int64_t>(1, static_cast<std::int64_t>(std::ceil(metrics.duration_s * 1e3 - 1e-6)))),
        images_hz_(images_hz) {
    go_on();
  }

  [[nodiscard]] std::int64_t start_us() const { return start_us_; }
  [[nodiscard]] std::int64_t end_ms() const { return end_ms_; }
  [[nodiscard]] std::int64_t time_us(std::int64_t ms) const { return start_us_ + 1000 * ms; }
  /// The next one, ms after the start; none after the end of the run, where the last one is.
  [[nodiscard]] std::optional<std::int64_t> next_ms() const { return next_ms_; }
  [[nodiscard]] std::optional<std::int64_t> next_us() const {
    return next_ms_ ? std::optional(time_us(*next_ms_)) : std::nullopt;
  }
  void go_on() {
    const std::int64_t last_ms = next_ms_.value_or(0);
    next_ms_.reset();
    if (last_ms == end_ms_) return;
    const double ms = static_cast<double>(++number_) * 1e3 / images_hz_;
    next_ms_ = std::min(end_ms_, static_cast<std::int64_t>(std::llround(ms)));
  }

 private:
  std::int64_t start_us_;
  std::int64_t end_ms_;
  double images_hz_;
  std::int64_t number_ = 0;
  std::optional<std::int64_t> next_ms_;
};

/// A table of a run folder that is read forward; without rows where the file does not exist.
template <class Row>
class TableCursor {
 public:
  explicit TableCursor(const std::filesystem::path& file) {
    if (!std::filesystem::exists(file)) return;
    reader_ = std::make_unique<TableReader<Row>>(file);
    next_ = reader_->next();
  }

  /// The first row after those that newest() or take() went over.
  [[nodiscard]] const std::optional<Row>& next() const { return next_; }
  [[nodiscard]] std::optional<std::int64_t> next_us() const {
    return next_ ? std::optional(next_->t_us) : std::nullopt;
  }
  /// next(), of which there is one; goes over it.
  Row take() {
    last_ = std::move(next_);
    next_ = reader_->next();
    return *last_;
  }
  /// The newest row up to a time, which does not go back over calls; null where it is older than `age_us`.
  const Row* newest(std::int64_t t_us, std::int64_t age_us) {
    while (next_ && next_->t_us <= t_us) (void)take();
    return last_ && t_us - last_->t_us <= age_us ? &*last_ : nullptr;
  }

 private:
  std::unique_ptr<TableReader<Row>> reader_;
  std::optional<Row> next_;
  std::optional<Row> last_;
};

/// A foxglove.CompressedImage (PNG) and a foxglove.RawImage of 32-bit numbers. `frame`: of the camera.
[[nodiscard]] nlohmann::ordered_json foxglove_png(std::int64_t t_us, const std::string& frame,
                                                  const cv::Mat& image);
[[nodiscard]] nlohmann::ordered_json foxglove_numbers(std::int64_t t_us, const std::string& frame,
                                                      const cv::Mat& image);

/// "left", "left_camera".
[[nodiscard]] std::string side_of(int camera);
[[nodiscard]] std::string frame_of(int camera);

using DetectorScores = std::vector<std::pair<std::string, DetectorScore>>;

/// Images of the events of some cameras, and how many there were in each ms. `summary` is filled as they are written.
[[nodiscard]] std::unique_ptr<FoxgloveTrack> event_track(const Metrics& metrics,
                                                         const ImageInstants& instants,
                                                         std::unique_ptr<EventReader> reader,
                                                         const std::set<std::uint8_t>& cameras,
                                                         FoxgloveWriter& writer, FoxgloveSummary& summary);
/// truth.csv
[[nodiscard]] std::unique_ptr<FoxgloveTrack> truth_track(const std::filesystem::path& table, int camera,
                                                         FoxgloveWriter& writer);
/// detections.csv, a topic for each detector, with the distance to the true circle's centre where it is known.
[[nodiscard]] std::unique_ptr<FoxgloveTrack> detection_track(const std::filesystem::path& table,
                                                             const std::filesystem::path& truth, int camera,
                                                             const DetectorScores& detectors,
                                                             FoxgloveWriter& writer);
/// gaze.csv and eye.csv: fixation point, target, the left eye's angle off the ball, the joints.
[[nodiscard]] std::unique_ptr<FoxgloveTrack> gaze_track(const std::filesystem::path& run_folder,
                                                        const Metrics& metrics, FoxgloveWriter& writer);
/// imu.csv
[[nodiscard]] std::unique_ptr<FoxgloveTrack> imu_track(const std::filesystem::path& table,
                                                       FoxgloveWriter& writer);

/// Images of ground_truth.h5 or .npz (docs/ground_truth.md), where the folder has one; else null. Of each array that the file
/// has: luminance and frame in grey, depth in m and magnitude of the flow in px/s as numbers, object numbers in colours. Throws
/// InputError for a broken file.
[[nodiscard]] std::unique_ptr<FoxgloveTrack> ground_truth_track(const std::filesystem::path& run_folder,
                                                                FoxgloveWriter& writer);

}  // namespace saccade
