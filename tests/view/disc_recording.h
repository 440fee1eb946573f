#pragma once

#include <gtest/gtest.h>

#include <vector>

#include "apps/view/playback.h"
#include "core/detectors/built_in_detectors.h"
#include "core/hough/hough_detector.h"
#include "tests/config/built_in.h"
#include "tests/core/streams.h"
#include "tests/recording/temp_folder.h"

namespace saccade {

/// A recording of a disc that moves for 0.4 s, its ground truth, and playbacks of it.
class DiscRecording : public testing::Test {
 protected:
  static constexpr ImageSize image{128, 128};
  static constexpr streams::MovingDisc disc{30, 50, 200, 60, 20};

  DiscRecording() {
    const auto writer = create_event_file(folder_ / "disc.aedat", image);
    writer->write(std::vector{streams::event_at(0, 127, 127, true)});  // time starts at 0
    writer->write(disc.events(image, 0.4));
    writer->commit();
    TableWriter<TruthRow> truth(folder_ / "truth.csv");
    for (std::int64_t t_us = 0; t_us <= 400'000; t_us += 5'000)
      truth.write({t_us, {disc.x_at(t_us), disc.y_at(t_us), disc.r_px}, 1.0, Eigen::Vector3d::Zero()});
    truth.commit();
    options_.recording = folder_ / "disc.aedat";
    options_.formats = built_in_formats();
    DetectorConfig directed = built_in_detectors().config("paper_directed");
    directed.get<HoughDetectorConfig>().window.events = 400;
    detectors_ = {{"paper_directed", directed}, {"best", built_in_detectors().config("best")}};
  }
  [[nodiscard]] std::unique_ptr<Playback> open() const {
    return make_recording_playback(options_, folder_ / "truth.csv", detectors_, "paper_directed", built_in());
  }
  static void seek(Playback& playback, std::int64_t t_us) {
    if (playback.history().now_us() >= t_us) playback.restore_before(t_us);
    ASSERT_LT(playback.history().now_us(), t_us);
    while (playback.history().now_us() < t_us) ASSERT_TRUE(playback.tick());
  }
  static Snapshot snapshot_of(Playback& playback) {
    Snapshot snapshot;
    playback.fill(snapshot);
    return snapshot;
  }

  TempFolder folder_;
  ReadOptions options_;
  NamedDetectors detectors_;
};

}  // namespace saccade
