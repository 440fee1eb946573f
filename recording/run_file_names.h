#pragma once

#include <string>
#include <vector>

namespace saccade {

class FormatRegistry;

/// Names of the files in a run folder (docs/run_folder.md), here alone.
namespace run_file {
inline constexpr const char* scenario = "scenario.yaml";
inline constexpr const char* detectors = "detectors.yaml";
inline constexpr const char* robot = "robot.yaml";
inline constexpr const char* joints = "joints.csv";
inline constexpr const char* truth = "truth.csv";
inline constexpr const char* truth_right = "truth_right.csv";
inline constexpr const char* target = "target.csv";
inline constexpr const char* detections = "detections.csv";
inline constexpr const char* detections_right = "detections_right.csv";
inline constexpr const char* streaming = "streaming.csv";
inline constexpr const char* gaze = "gaze.csv";
inline constexpr const char* eye = "eye.csv";
inline constexpr const char* imu = "imu.csv";
inline constexpr const char* labels = "labels.csv";
inline constexpr const char* labels_right = "labels_right.csv";
inline constexpr const char* ground_truth_hdf5 = "ground_truth.h5";
inline constexpr const char* ground_truth_npz = "ground_truth.npz";
inline constexpr const char* timing = "timing.csv";
inline constexpr const char* metrics = "metrics.json";
inline constexpr const char* figures_json = "figures.json";
inline constexpr const char* deploy = "deploy.json";
inline constexpr const char* serve = "serve.json";
inline constexpr const char* report = "report.html";
inline constexpr const char* scene = "scene.json";
inline constexpr const char* replay = "replay.html";
inline constexpr const char* video = "video.mp4";
inline constexpr const char* video_part = "video.part.mp4";
inline constexpr const char* log = "log.txt";
inline constexpr const char* lock = "lock";        ///< while the run is made; not among run_file_names()
inline constexpr const char* frames = "frames";    ///< folder
inline constexpr const char* figures = "figures";  ///< folder

/// The event file for a choice of `output.events`: "events.aedat" for "aedat".
[[nodiscard]] inline std::string events(const std::string& format) { return "events." + format; }
}  // namespace run_file

/// All names that a run may leave in its folder, event files of every format and their companions included.
[[nodiscard]] std::vector<std::string> run_file_names(const FormatRegistry& formats);

}  // namespace saccade
