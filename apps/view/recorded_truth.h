#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "apps/view/snapshot.h"
#include "recording/run_files.h"

namespace saccade {

/// Ground truth of a recording: its true circles and, of a run folder, the poses of the left camera and the gaze targets.
class RecordedTruth {
 public:
  RecordedTruth() = default;
  /// `annotated`: circles were marked by hand at single instants; then each is shown for 20 ms. `camera` projects the
  /// gaze targets.
  RecordedTruth(std::vector<TruthRow> circles, bool annotated, const Camera& camera)
      : circles_(std::move(circles)), annotated_(annotated), camera_(camera) {}

  /// Reads eye.csv and gaze.csv of a run folder, where they exist. Throws InputError for broken ones.
  void read_gaze(const std::filesystem::path& folder);

  [[nodiscard]] SnapshotTruth at(std::int64_t t_us) const;
  /// Time of the last gaze row; none where there is none.
  [[nodiscard]] std::optional<std::int64_t> last_us() const;

 private:
  std::vector<TruthRow> circles_;
  std::vector<EyeRow> eye_rows_;
  std::vector<GazeRow> gaze_rows_;
  bool annotated_ = false;
  Camera camera_;
};

}  // namespace saccade
