#pragma once

#include <memory>

#include "recording/event_file.h"

namespace saccade {

/// One recording of two: the events of `left` as those of camera 0 and of `right` as those of camera 1, merged by time, at
/// the same time the left ones first. Time that goes back in one of them goes back here.
[[nodiscard]] std::unique_ptr<EventReader> merge_cameras(std::unique_ptr<EventReader> left,
                                                         std::unique_ptr<EventReader> right);

/// The file of the right camera beside `path`: a/b.raw gives a/b_right.raw.
[[nodiscard]] std::filesystem::path right_camera_file(const std::filesystem::path& path);

/// A writer that passes the events of camera 0 to `left` and those of camera 1, as those of the only camera, to `right`.
/// commit() commits the right one first.
[[nodiscard]] std::unique_ptr<EventWriter> split_cameras(std::unique_ptr<EventWriter> left,
                                                         std::unique_ptr<EventWriter> right);

}  // namespace saccade
