#include "apps/serve/serve_session.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>

#include "apps/config/scenario.h"
#include "apps/serve/gaze_server.h"
#include "apps/session/interrupt.h"
#include "apps/session/progress.h"
#include "apps/session/run_folder.h"
#include "apps/session/run_recorder.h"
#include "apps/session/scenario_loop.h"
#include "apps/session/summary.h"
#include "apps/session/version.h"
#include "evaluation/report/report.h"
#include "loop/loop.h"
#include "recording/output_file.h"
#include "robot/yarp/control_board.h"
#include "robot/yarp/event_port.h"
#include "robot/yarp/gaze_ports.h"

namespace saccade {
namespace {

using SteadyClock = std::chrono::steady_clock;
using std::chrono::microseconds;

constexpr std::int64_t catch_up_us = 20'000;
constexpr double least_interval_ms = 1.0;  // from one image to the next: more cannot be drawn in real time
constexpr int gaze_report_ticks = 10;      // of iKinGazeCtrl's ports: 10 ms
constexpr std::int64_t commands_end_us = 100'000;  // a stream of commands that paused for so long has ended

/// Which of the names in a list this one is.
template <class Enum>
Enum choice(const char* option, const std::string& name, const std::vector<std::string>& names) {
  const auto found = std::ranges::find(names, name);
  if (found == names.end()) throw InputError(option, name, fmt::format("one of {}", fmt::join(names, ", ")));
  return static_cast<Enum>(found - names.begin());
}

JointBoard board_of(const JointLimits& limits, const JointVector& position_rad, std::span<const Joint> joints,
                    bool movable) {
  std::vector<JointBoard::Joint> ranges;
  Eigen::VectorXd position(static_cast<Eigen::Index>(joints.size()));
  for (const Joint joint : joints) {
    position[static_cast<Eigen::Index>(ranges.size())] = position_rad[joint];
    ranges.push_back({limits.min_rad[joint], limits.max_rad[joint], limits.max_speed_rad_s[joint]});
  }
  return {ranges, position, movable};
}

constexpr std::array head_joints = {neck_pitch, neck_roll, neck_yaw, eyes_tilt, eyes_version, eyes_vergence};
constexpr std::array torso_motors = {torso_yaw, torso_roll, torso_pitch};  // the order of the part torso

std::vector<std::string> names_of(std::span<const Joint> joints) {
  std::vector<std::string> names;
  for (const Joint joint : joints) names.emplace_back(joint_names.at(static_cast<std::size_t>(joint)));
  return names;
}

/// What happens on the ports, a line each, in the run folder and on standard error.
class ServeLog {
 public:
  ServeLog(const std::filesystem::path& file, Progress& progress) : file_(file), progress_(progress) {}
  void write(std::int64_t t_us, const std::string& text) {
    const std::string line = fmt::format("{:9.3f} s  {}", static_cast<double>(t_us) * 1e-6, text);
    file_.write(line + "\n");
    progress_.done();
    fmt::print(stderr, "{}\n", line);
  }
  void finish() { file_.commit(); }

 private:
  OutputFile file_;
  Progress& progress_;
};

/// The robot's ports, and what passes between them and the simulated robot in each tick.
class ServedRobot final : public LoopObserver {
 public:
  ServedRobot(const ServeOptions& options, const Scenario& scenario, SimRobot& robot, ServeLog& log)
      : robot_(robot),
        log_(log),
        gaze_(ikingaze_of(scenario.gaze.controller), scenario.gaze.controller.limits, robot.limits(),
              scenario.calibration.camera,
              scenario.sim.both_eyes() ? scenario.right_calibration.camera : scenario.calibration.camera,
              start_of(robot).position_rad),
        camera_({options.camera, choice<PacketFormat>("--format", options.format, packet_format_names()),
                 choice<AddressCodec>("--codec", options.codec, address_codec_names()), 100'000}),
        head_({"/" + options.robot + "/head", names_of(head_joints), options.state_period_ms * 1e-3},
              board_of(robot.limits(), start_of(robot).position_rad, head_joints, true)),
        torso_({"/" + options.robot + "/torso", names_of(torso_motors), options.state_period_ms * 1e-3},
               board_of(robot.limits(), start_of(robot).position_rad, torso_motors, false)),
        gaze_ports_("/" + options.gaze,
                    [this](const std::string& request) { return gaze_.answer(request); }) {}

  /// Somebody reads the camera, and somebody has taken the head or told the gaze controller something.
  [[nodiscard]] bool is_taken() {
    return camera_.readers() > 0 && (head_.use().modes + head_.use().commands + gaze_.report().orders > 0);
  }
  /// A tick while the world stands still.
  void wait() {
    HeadState state;
    robot_.read(state);
    move(state, 0.0);
    camera_.send({}, robot_.now_us());
    report();
  }
  void on_tick(const Tick& tick) override {
    const double dt_s = static_cast<double>(tick.t_us - t_us_) * 1e-6;
    t_us_ = tick.t_us;
    if (const auto reference_rad = gaze_.step(*tick.head, dt_s)) head_.drive(*reference_rad);
    robot_.command(move(*tick.head, dt_s));
    camera_.send(tick.events, tick.t_us);
    events_ += static_cast<std::int64_t>(tick.events.size());
    report();
    watch();
  }
  /// What the gaze controller looks at.
  [[nodiscard]] const std::optional<Eigen::Vector3d>& target_m() const { return target_m_; }
  [[nodiscard]] std::int64_t commands() const { return head_.use().commands; }
  [[nodiscard]] int readers() const { return camera_.readers(); }
  [[nodiscard]] std::string traffic() const {
    const YarpControlBoard::Use use = head_.use();
    return fmt::format(
        "{} events in {} packets, {} events left out; {} commands for joints, {} refused; {} orders for the "
        "gaze",
        events_, camera_.messages(), camera_.dropped(), use.commands, use.refused, orders_);
  }

 private:
  static IkinGazeConfig ikingaze_of(GazeControllerConfig config) {
    const IkinGazeConfig* const ikingaze = config.configs.get_if<IkinGazeConfig>();
    return ikingaze != nullptr ? *ikingaze : IkinGazeConfig{};
  }
  static HeadState start_of(SimRobot& robot) {
    HeadState state;
    robot.read(state);
    return state;
  }
  HeadCommand move(const HeadState& state, double dt_s) {
    Eigen::VectorXd position(3), velocity(3);
    for (int i = 0; i < 3; ++i) {
      position[i] = state.position_rad[torso_motors.at(static_cast<std::size_t>(i))];
      velocity[i] = state.velocity_rad_s[torso_motors.at(static_cast<std::size_t>(i))];
    }
    torso_.step(position, velocity, dt_s);
    return head_.step(state.head_position_rad(), state.velocity_rad_s.tail<head_joint_count>(), dt_s);
  }
  void report() {
    const GazeServer::Report report = gaze_.report();
    for (const std::string& event : report.events) events_to_tell_.push_back(event);
    target_m_ = report.target_m;
    orders_ = report.orders;
    if (++ticks_ % gaze_report_ticks != 0) return;
    gaze_ports_.send(report.fixation_m, report.position_rad, report.angles_deg, events_to_tell_);
    events_to_tell_.clear();
  }
  /// A line for each change.
  void watch() {
    if (const int readers = camera_.readers(); readers != readers_) {
      log_.write(t_us_, fmt::format("the camera has {} reader{}", readers, readers == 1 ? "" : "s"));
      readers_ = readers;
    }
    if (const std::int64_t commands = head_.use().commands; commands != commands_) {
      if (!commanded_) log_.write(t_us_, "commands come for the head's joints");
      commanded_ = true;
      commands_ = commands;
      commanded_us_ = t_us_;
    } else if (commanded_ && t_us_ - commanded_us_ >= commands_end_us) {
      log_.write(t_us_, "no command for the head's joints for 100 ms: they hold");
      commanded_ = false;
    }
    if (target_m_.has_value() != looking_) {
      looking_ = target_m_.has_value();
      log_.write(t_us_, looking_ ? "the gaze controller has a target" : "the gaze controller was stopped");
    }
  }

  SimRobot& robot_;
  ServeLog& log_;
  GazeServer gaze_;
  YarpEventPort camera_;
  YarpControlBoard head_;
  YarpControlBoard torso_;
  YarpGazePorts gaze_ports_;
  std::int64_t t_us_ = 0;
  std::int64_t ticks_ = 0;
  std::int64_t events_ = 0;
  std::int64_t orders_ = 0;
  std::optional<Eigen::Vector3d> target_m_;
  std::vector<std::string> events_to_tell_;
  int readers_ = 0;
  std::int64_t commands_ = 0;
  std::int64_t commanded_us_ = 0;
  bool commanded_ = false;
  bool looking_ = false;
};

/// Ticks of the wall clock.
class Pace {
 public:
  void wait() {
    due_ += microseconds(World::tick_us);
    busy_ += SteadyClock::now() - begun_;
    std::this_thread::sleep_until(due_);
    begun_ = SteadyClock::now();
    const auto late = begun_ - due_;
    latest_ = std::max(latest_, late);
    if (late > microseconds(catch_up_us)) {
      slipped_ += late - microseconds(catch_up_us);
      due_ += late - microseconds(catch_up_us);
    }
  }
  void restart() { *this = Pace(); }
  [[nodiscard]] double busy_s() const { return std::chrono::duration<double>(busy_).count(); }
  [[nodiscard]] double slipped_s() const { return std::chrono::duration<double>(slipped_).count(); }
  [[nodiscard]] double latest_ms() const {
    return std::chrono::duration<double, std::milli>(latest_).count();
  }

 private:
  SteadyClock::time_point due_ = SteadyClock::now();
  SteadyClock::time_point begun_ = due_;
  SteadyClock::duration busy_{}, slipped_{}, latest_{};
};

/// The scenario as it is recorded: what detects and follows is somebody else, and there is no time for pictures.
Scenario as_served(Scenario scenario) {
  scenario.detectors.clear();
  scenario.frame_30hz.reset();
  scenario.gaze.detector = "remote";
  scenario.gaze.controller.controller = "remote";
  scenario.gaze.gate.gate = "remote";
  scenario.output.pictures = 0;
  scenario.output.video = false;
  return scenario;
}

/// Ports first, then the truth, which is that of after the tick.
class Observers final : public LoopObserver {
 public:
  Observers(ServedRobot& served, RunRecorder& recorder) : served_(served), recorder_(recorder) {}
  void on_tick(const Tick& tick) override {
    served_.on_tick(tick);
    Tick seen = tick;
    seen.target_m = served_.target_m();
    recorder_.on_tick(seen);
  }

 private:
  ServedRobot& served_;
  RunRecorder& recorder_;
};

}  // namespace

int serve(const ServeOptions& options, const Registry& registry) {
  Scenario scenario = read_scenario(options.scenario, options.assignments, options.seed, registry);
  SamplingConfig& sampling = scenario.sim.sampling;
  sampling.min_interval_ms =
      std::min(std::max(sampling.min_interval_ms, least_interval_ms), sampling.max_interval_ms);
  const std::filesystem::path folder =
      options.out.empty() ? std::filesystem::path("runs") / (scenario.name + "_served") : options.out;
  set_rasterisers(scenario.run.threads);
  SimRobot robot(scenario.sim, static_cast<std::uint64_t>(scenario.seed));
  prepare_run_folder(folder, options.force);
  {
    OutputFile resolved(folder / "scenario.yaml");
    resolved.write(version_line() + ", served; " + robot.gl_description() + "\n" +
                   resolved_scenario(scenario));
    resolved.commit();
  }
  Progress progress(options.endless ? 0.0 : scenario.run.duration_s);
  ServeLog log(folder / "log.txt", progress);
  catch_interrupts();
  ServedRobot served(options, scenario, robot, log);
  Loop loop(robot, scenario.calibration, {}, std::nullopt);
  const Scenario recorded = as_served(scenario);
  RunRecorder recorder(folder, recorded, robot, loop);
  Observers observers(served, recorder);

  log.write(0, fmt::format("/{0}/head, /{0}/torso, {1} and /{2} are there", options.robot, options.camera,
                           options.gaze));
  Pace pace;
  if (options.wait_for_client) {
    log.write(0, "the world waits for a client");
    while (!interrupted() && !served.is_taken()) {
      pace.wait();
      served.wait();
    }
    if (interrupted()) throw RunError("interrupted before a client came");
    pace.restart();
  }
  const std::int64_t end_us = options.endless ? INT64_MAX : std::llround(scenario.run.duration_s * 1e6);
  const auto begin = SteadyClock::now();
  const auto wall_s = [&] { return std::chrono::duration<double>(SteadyClock::now() - begin).count(); };
  std::int64_t t_us = 0;
  std::int64_t commands = 0;
  double shown_s = 0.0;
  while (t_us < end_us && !interrupted()) {
    pace.wait();
    t_us += World::tick_us;
    loop.tick(t_us, observers);
    const double t_s = static_cast<double>(t_us) * 1e-6;
    progress.show(t_s, [&] {
      const double rate_hz =
          static_cast<double>(served.commands() - commands) / std::max(wall_s() - shown_s, 1e-3);
      commands = served.commands();
      shown_s = wall_s();
      return fmt::format(
          "{:6.2f} s, {:.2f} x real time, {:.0f} % busy, {} reader{}, {:.0f} commands per second", t_s,
          t_s / std::max(shown_s, 1e-9), 100.0 * pace.busy_s() / std::max(shown_s, 1e-9), served.readers(),
          served.readers() == 1 ? "" : "s", rate_hz);
    });
  }
  const double loop_s = wall_s();
  progress.done();
  log.write(t_us, served.traffic());
  log.write(t_us,
            fmt::format("{:.0f} % busy; latest tick {:.1f} ms, the world slipped by {:.3f} s",
                        100.0 * pace.busy_s() / std::max(loop_s, 1e-9), pace.latest_ms(), pace.slipped_s()));
  log.finish();
  const Metrics metrics = recorder.finish(loop_s, settings_of(options.assignments));
  write_report(folder);
  print_summary(metrics);
  fmt::print("{}\n", (folder / "report.html").string());
  if (interrupted()) throw RunError("interrupted; the run folder holds what happened until then");
  return 0;
}

}  // namespace saccade
