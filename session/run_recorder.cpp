#include "session/run_recorder.h"

#include <map>

#include "config/input_files.h"
#include "session/interrupt.h"

#include "recording/run_file_names.h"

namespace saccade {
namespace {

std::optional<FrameCamera> frame_camera(const Scenario& scenario, SimRobot& robot) {
  if (!scenario.frame_30hz) return std::nullopt;
  return std::optional<FrameCamera>(std::in_place, *scenario.frame_30hz, scenario.sim, scenario.latency,
                                    robot);
}

}  // namespace

RunRecorder::RunRecorder(std::optional<std::filesystem::path> folder, const Scenario& scenario,
                         SimRobot& robot, const Loop& loop)
    : folder_(std::move(folder)),
      scenario_(scenario),
      robot_(robot),
      truth_(robot),
      frames_(frame_camera(scenario, robot)),
      observations_(loop, truth_, frames_ ? &*frames_ : nullptr, scenario.latency),
      scores_(scenario, truth_, robot.limits(), loop, observations_, frames_ ? &*frames_ : nullptr),
      files_(InputFiles().of(scenario)) {
  if (!folder_) return;
  tables_.emplace(*folder_, scenario, truth_, loop, observations_, robot.imu());
  pictures_.emplace(*folder_, scenario, robot, loop, scores_);
  scene_.emplace(*folder_, robot);
  if (scenario.output.ground_truth) ground_truth_.emplace(*folder_, scenario, robot);
}

void RunRecorder::on_tick(const Tick& tick) {
  if (frames_) frames_->on_tick(tick);
  observations_.on_tick(tick);
  if (tables_) tables_->on_tick(tick);
  scores_.on_tick(tick);
  if (pictures_) pictures_->on_tick(tick);
  if (scene_) scene_->on_tick(tick);
  if (ground_truth_) ground_truth_->on_tick(tick);
}

double RunRecorder::picture_wall_s() const {
  return (frames_ ? frames_->wall_s() : 0.0) + (pictures_ ? pictures_->wall_s() : 0.0) +
         (ground_truth_ ? ground_truth_->wall_s() : 0.0);
}

Metrics RunRecorder::finish(double wall_s, std::vector<std::pair<std::string, std::string>> settings) {
  observations_.finish();
  if (tables_) tables_->commit();
  if (pictures_) pictures_->commit();
  if (scene_) scene_->commit();
  if (ground_truth_) ground_truth_->commit();
  Metrics metrics = scores_.metrics();
  metrics.settings = std::move(settings);
  metrics.wall_s = wall_s;
  metrics.interrupted = interrupted() && metrics.duration_s < scenario_.run.duration_s - 1e-9;
  metrics.files = files_;
  metrics.events_dropped = robot_.left_eye().counts().dropped;
  if (metrics.right_eye) metrics.right_eye->events_dropped = robot_.right_eye()->counts().dropped;
  if (folder_) {
    metrics.events_file = event_file_name(scenario_);
    write_metrics(*folder_ / run_file::metrics, metrics);
    write_figures(*folder_ / run_file::figures_json, metrics);
  }
  return metrics;
}

std::vector<std::pair<std::string, std::string>> settings_of(const std::vector<std::string>& assignments) {
  std::map<std::string, std::string> settings;
  for (const std::string& assignment : assignments) {
    const std::size_t equals = assignment.find('=');
    const std::string key = assignment.substr(0, equals);
    const std::string section = key.substr(0, key.find('.'));
    if (section == "output" || section == "run" || section == "seed" || section == "expect") continue;
    settings[key] = assignment.substr(equals + 1);
  }
  return {settings.begin(), settings.end()};
}

}  // namespace saccade
