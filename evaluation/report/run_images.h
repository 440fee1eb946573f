#pragma once

#include <cstdint>
#include <string>

#include "evaluation/report/overlay.h"
#include "evaluation/report/run_data.h"

namespace saccade {

/// The images of a run's report, as HTML figures; empty where the run has nothing to show. Throw InputError for a
/// saved image that cannot be read or has another size than the camera.

/// Whether circles have the names of their detectors beside them.
enum class CircleNames : std::uint8_t { no, yes };
/// What the left eye sees at frame.t_us, with the true circle, each detector's newest circle of the last `window_us` at or above its threshold,
/// and the gaze target. It shows frame.events, which must outlive it.
[[nodiscard]] AnnotatedImage left_image(const RunData& run, const Frame& frame, std::int64_t window_us,
                                        CircleNames names = CircleNames::no);
/// The right eye's image, with the true circle, of a run with two eyes; it shows frame.other_events.
[[nodiscard]] AnnotatedImage right_image(const RunData& run, const Frame& frame);

/// The eye's images with events, truth and detections, and the scene beside them where it was saved.
[[nodiscard]] std::string frames_figure(const RunData& run);
/// The accumulated Hough spaces over the events (paper, Fig. 2).
[[nodiscard]] std::string hough_figure(const RunData& run);
/// The eye's images before and after the largest gaze shifts (paper, Fig. 6).
[[nodiscard]] std::string shifts_figure(const RunData& run);

}  // namespace saccade
