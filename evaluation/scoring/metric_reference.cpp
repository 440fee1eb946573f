#include "evaluation/scoring/metric_reference.h"

namespace saccade {
namespace {

constexpr MetricRow rows[] = {
    {"schema", "whole number", "1"},
    {"scenario", "text", "name of the scenario"},
    {"seed", "whole number", "of the run"},
    {"settings", "block", "the overrides of the scenario (`--set`) without `output.*` and `run.*`"},
    {"start_us", "whole number", "time of the events' clock at the start of the run"},
    {"duration_s", "number", "length of the run in its own time"},
    {"wall_s", "number", "computing time of the loop alone, without images, video, frame camera and report"},
    {"real_time_factor", "number", "`duration_s` / `wall_s`"},
    {"interrupted", "true or false",
     "whether the run ended before its time: all figures are of what was processed until then"},
    {"events.count", "whole number", "events that the detectors got, of both eyes"},
    {"events.rate_hz", "number", "`count` / `duration_s`"},
    {"events.dropped", "whole number", "events of the left camera that its bus dropped"},
    {"events.dropped_share", "number", "their share of the left camera's events; above 0.01 a warning"},
    {"events.file", "text", "the event file"},
    {"events.camera", "left or right", "of a recording: the camera whose events the detectors got"},
    {"camera", "block", "the true camera"},
    {"calibration", "block", "the assumed calibration"},
    {"files", "list of blocks", "`key`, `file` and `digest` of each file that the run read"},
    {"controller_failure", "text",
     "of a deployed run: why a controller in a program of its own ended before the run"},
    {"latency.kind", "model or measured", "the latencies of the run"},
    {"latency.detectors.NAME.busy_ratio", "number", "processing time / time of the run"},
    {"latency.detectors.NAME.events_left_out", "whole number", "events dropped because too many waited"},
    {"clutter.share", "number", "clutter events / all events"},
    {"clutter.by_object", "block", "share of all events by object"},
    {"clutter.by_cause", "block", "share of all events by cause"},
    {"right_eye.events", "block", "`count`, `dropped` and `dropped_share` of the right camera"},
    {"right_eye.camera", "block", "as `camera`"},
    {"right_eye.calibration", "block", "as `calibration`"},
    {"right_eye.fixation_error_deg", "block", "as `gaze.fixation_error_deg`, of the right eye's axis"},
    {"right_eye.on_target_ratio", "number", "as `gaze.on_target_ratio`"},
    {"right_eye.in_view_ratio", "number", "as `gaze.in_view_ratio`"},
    {"right_eye.detectors", "block", "as `detectors`, of the detectors that got the right eye's events"},

    {"detectors.NAME.chances", "whole number", "number of chances"},
    {"detectors.NAME.threshold", "number", "the threshold"},
    {"detectors.NAME.observations", "whole number", "observations at or above the threshold that count"},
    {"detectors.NAME.inliers", "whole number", "those of them that are inliers"},
    {"detectors.NAME.precision", "number", "inliers / observations"},
    {"detectors.NAME.recall", "number", "inliers / chances"},
    {"detectors.NAME.average_precision", "number",
     "the sum of precision times recall step over all distinct scores, without interpolation"},
    {"detectors.NAME.precision_at_recall", "block",
     "the precision at the highest threshold whose recall reaches 0.1, 0.2, 0.3, 0.5, 0.7 or 0.9; `null` if "
     "none does"},
    {"detectors.NAME.pr_curve", "list of blocks",
     "`precision` and `recall` by falling `threshold`, at most 200 points"},
    {"detectors.NAME.detection_rate_hz", "block",
     "inliers per second, in bins of 100 ms that hold at least one chance: `mean`, and `peak` of the bins "
     "wholly inside the run. `null` for recordings"},
    {"detectors.NAME.position_error_px", "block",
     "distance between the centres: `median` and `p95` over all observations at chances, inlier or not. Lag "
     "is not compensated"},
    {"detectors.NAME.radius_error_px", "block", "absolute difference of the radii, likewise"},
    {"detectors.NAME.lag_ms", "number",
     "the shift s in [-50, 200] ms, in steps of 0.1 ms, that minimises the median distance between the "
     "observation at t and the ground truth at t - s. Positive: the detector is late. `null` if the true "
     "centre moves by less than 6 px, is slower than 30 px/s in the median, or if the ground truth has gaps "
     "of more than 20 ms"},
    {"detectors.NAME.alarm_ratio", "number",
     "where there is no ball at all (a world without one; `saccade detect --no-ball`): the share of the "
     "instants of 1 ms with an observation. `null` elsewhere"},
    {"detectors.NAME.alarms_per_min", "number",
     "there too: alarms per minute. Observations less than 100 ms apart are one alarm"},
    {"detectors.NAME.reliability", "list of blocks",
     "whether the score is a probability: ten bins of the score, each with `from`, the `count` of the "
     "observations, the `inliers`, their share (`inlier_share`) and the `mean_score`, whatever the "
     "threshold. "
     "`null` for a detector with a score outside 0 to 1"},
    {"detectors.NAME.nees", "block",
     "whether the covariance C of (x, y, r) agrees with the errors e: of the inliers the `count`, the "
     "`share` "
     "with e' C^-1 e below 7.81 (95 % of a chi-squared variable with three degrees of freedom), and the "
     "`median` (2.37 for errors with exactly that covariance)"},
    {"detectors.NAME.us_per_event", "number", "processing time per event, us, flow included"},
    {"detectors.NAME.rejected_events", "block",
     "events that the detector did not use: `outside_image`, `back_in_time`"},
    {"detectors.NAME.streaming.average_precision", "number", "of the newest estimates that were ready"},
    {"detectors.NAME.streaming.precision", "number", "likewise"},
    {"detectors.NAME.streaming.recall", "number", "likewise"},
    {"detectors.NAME.streaming.latency_ms", "block",
     "from the instant that an estimate is about to the time at which it was ready, over all observations: "
     "`median` and `p99`"},
    {"detectors.NAME.streaming.approximate", "true", "in very long runs"},
    {"detectors.NAME.clutter_in_window", "block",
     "mean share of clutter among the newest 1500 events: `detected`, over the chances with an observation "
     "at "
     "or above the threshold; `missed`, over the others"},
    {"detectors.NAME.clutter_per_detection", "number", "clutter events of the run per inlier"},
    {"detectors.NAME.approximate", "true", "in very long runs"},
    {"detectors.NAME.failure", "text", "why a detector in a program of its own ended before the run"},

    {"gaze.acquire_s", "number",
     "time from the first motion of the ball to the start of the first 100 ms within `acquire_within_deg` of "
     "it"},
    {"gaze.acquire_within_deg", "number",
     "2 by default; scenarios in which a detector of the paper controls the gaze say 6"},
    {"gaze.acquired_at_us", "whole number", "the instant at which `acquire_s` ends"},
    {"gaze.fixation_error_deg", "block",
     "* the angle at the left eye between its optical axis and the centre of the ball: `median` and `p95`"},
    {"gaze.on_target_ratio", "number", "* the share of instants with a fixation error below 2 deg"},
    {"gaze.in_view_ratio", "number", "* the share of instants with the centre of the ball inside the image"},
    {"gaze.following_rate_hz", "number",
     "* 1000 times the share of the chances with an inlier of the detector that controls the gaze"},
    {"gaze.moves", "whole number",
     "gaze targets that differ from the target of the last move by more than 1 mm; the first target is one"},
    {"gaze.wrong_moves", "whole number",
     "moves whose target, projected through the true camera at that moment, is more than 6 px from the "
     "centre "
     "of the ball or behind the camera"},
    {"gaze.target_error_m", "block",
     "the distance between the target of a move and the centre of the ball: `median`"},
    {"gaze.saccades", "whole number",
     "stretches of at least 10 ms in which the eye turns faster than 60 deg/s"},
    {"gaze.limit_violations", "whole number",
     "ticks with a joint of the plant more than 0.01 deg outside its limits"},
    {"gaze.joint_limits_rad", "block", "limits of the joints, for the figures"},
    {"gaze.detector", "text", "the detector that controls the gaze"},
    {"gaze.controller", "text", "the controller"},
    {"gaze.gate", "text", "the gate"},
    {"gaze.window", "text", "window of the detector's events"},
    {"gaze.approximate", "true", "in very long runs"},
    {"gaze.failure", "text", "why a controller in a program of its own ended before the run"},

    {"gaze.eye_movements.pursuit", "block",
     "gain and phase of gaze over ball (directions from the left eye in the root frame), at the frequency of "
     "a trajectory `circle`, over whole periods; of azimuth and elevation the one in which the ball moves "
     "more"},
    {"gaze.eye_movements.pursuit_lag_ms", "number", "the phase as a time"},
    {"gaze.eye_movements.stabilisation", "block",
     "gain and phase of the counter-rotation at the frequency of the sway: 1 - L / S, where L is the "
     "oscillation of the ball's bearing in the left camera and S the same if neck and eyes had kept their "
     "first pose. A gain of 1 with a phase of 0 cancels the sway"},
    {"gaze.eye_movements.slip_reduction", "number", "1 - abs(L / S)"},
    {"gaze.eye_movements.steps", "list of blocks",
     "jumps of the ball by 1 deg or more: size, latency from the jump until the gaze turns at 20 deg/s, peak "
     "speed over 10 ms, time until the gaze stays within 1 deg (none: not within 0.7 s)"},
    {"gaze.eye_movements.ramps", "block",
     "speed of the ball, gain and mean lag of the gaze in the middle halves of ramps, from the second one "
     "on"},
    {"gaze.eye_movements.main_sequence", "block",
     "line through peak speed over size of the saccades (faster than 60 deg/s for 10 ms), least squares"},
    {"gaze.eye_movements.error_deg", "block", "angle between gaze and ball"},
    {"gaze.eye_movements.image_motion_px_s", "block",
     "motion of the ball in the left camera over 10 ms (retinal slip)"},
};

}  // namespace

std::span<const MetricRow> metric_reference() { return rows; }

}  // namespace saccade
