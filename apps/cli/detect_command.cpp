#include <fmt/format.h>

#include <filesystem>
#include <memory>

#include "apps/cli/commands.h"
#include "apps/cli/read_options.h"
#include "apps/cli/web_option.h"
#include "apps/live/live_feed.h"
#include "apps/live/live_message.h"
#include "config/scenario.h"
#include "session/detect_recording.h"

namespace saccade {
namespace {

struct DetectOptions {
  std::filesystem::path config;
  std::vector<std::string> assignments;
  DetectSettings settings;
  std::optional<LiveAddress> web;
};

/// Those of --config; else those of the run whose folder is read, which is printed; else the registry's defaults.
NamedDetectors detectors_for(const DetectOptions& options, const DetectorRegistry& registry) {
  const ReadOptions& input = options.settings.input;
  if (options.config.empty() && is_run_folder(input)) {
    if (const auto own = read_recorded_detectors(input.recording, options.assignments, registry)) {
      std::string names;
      for (const auto& [name, config] : own->detectors) names += (names.empty() ? "" : ", ") + name;
      fmt::print(stderr, "saccade: the detectors of {}: {}\n", own->file.string(), names);
      return own->detectors;
    }
  }
  return read_detectors(options.config, options.assignments, registry);
}

void detect(const DetectOptions& options, const DetectorRegistry& registry) {
  const NamedDetectors detectors = detectors_for(options, registry);
  if (!options.web) return detect_recording(detectors, options.settings);
  LiveServer server({.address = *options.web, .page = live_page()});
  fmt::print(stderr, "live page: {}\n", server.link());
  std::optional<LiveFeed> feed;
  DetectSettings settings = options.settings;
  settings.observe = [&](const Loop& loop, ImageSize size) -> LoopObserver* {
    return &feed.emplace(
        server,
        LiveRun{.title = settings.input.recording.filename().string(), .kind = "detect", .size = size}, loop);
  };
  detect_recording(detectors, settings);
}

}  // namespace

void add_detect_command(CommandLine& line, const Registry& registry) {
  auto options = std::make_shared<DetectOptions>();
  DetectSettings& settings = options->settings;
  Command command =
      line.add_command("detect", "The detectors on recorded events, scored when truth is given");
  add_read_options(command, "recording", "Event file, or a run folder with its joints and truth",
                   settings.input, registry.formats);
  command.option(
      "--config", options->config,
      "Detectors (YAML). Without it: those of the run for a run folder that has some, else those of "
      "the paper and `best`");
  command
      .option("--set", options->assignments,
              "key=value for every detector, DETECTOR.key=value for one; e.g. radius_px=[4,25]")
      .one_value_each();
  Option truth = command.option("--truth", settings.truth, "True circles, t_us,x_px,y_px,r_px (CSV)");
  command
      .flag("--no-ball", settings.no_ball,
            "The recording shows no ball: every observation is false, and alarm_ratio is the share of the "
            "milliseconds with one at or above the threshold")
      .excludes(truth);
  command.option("--joints", settings.joints,
                 "Joints of the head: joints.csv of a run folder, or a data dumper's log of its state port");
  command.option("--calibration", settings.calibration,
                 "Assumed calibration of the camera (YAML of calibrate, OpenCV, ROS or Kalibr)");
  Option folder = command.option("--out", settings.folder, "Folder for detections, scores and report");
  command.flag("--json", settings.json, "The scores as metrics.json on standard output").excludes(folder);
  add_web_option(command, options->web);
  command.flag("--force", settings.force, "Replace an earlier run in that folder");
  command.action([options, &registry] {
    detect(*options, registry.detectors);
    return 0;
  });
}

}  // namespace saccade
