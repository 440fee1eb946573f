#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "evaluation/replay/foxglove_writer.h"
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

/// Images of ground_truth.h5 or .npz (docs/ground_truth.md), where the folder has one; else null. Of each array that the file
/// has: luminance and frame in grey, depth in m and magnitude of the flow in px/s as numbers, object numbers in colours. Throws
/// InputError for a broken file.
[[nodiscard]] std::unique_ptr<FoxgloveTrack> ground_truth_track(const std::filesystem::path& run_folder,
                                                                FoxgloveWriter& writer);

}  // namespace saccade
