#include "apps/serve/serve_session.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <memory>
#include <optional>
#include <thread>
#include <utility>

#include "apps/live/live_feed.h"
#include "apps/live/live_message.h"
#include "apps/live/live_truth.h"
#include "apps/serve/image_pace.h"
#include "apps/serve/moving_speed.h"
#include "apps/serve/paced_robot.h"
#include "apps/serve/served_external.h"
#include "apps/serve/served_ports.h"
#ifdef SACCADE_YARP
#include "apps/serve/served_robot.h"
#endif
#include "config/scenario.h"
#include "core/error.h"
#include "recording/output_file.h"
#include "recording/run_file_names.h"
#include "session/close_within.h"
#include "session/interrupt.h"
#include "session/log_file.h"
#include "session/progress.h"
#include "session/real_time.h"
#include "session/run_folder.h"
#include "session/run_recorder.h"
#include "session/scenario_loop.h"
#include "session/session.h"
#include "session/summary.h"
#include "session/version.h"

namespace saccade {
namespace {

constexpr double least_image_interval_ms = 1.0;  // more images cannot be drawn in real time
/// An interrupt ends the program within 2 s, of which the report of 198 s with 12 million events would take 2.2.
constexpr double longest_report_s = 60.0;
constexpr std::int64_t most_reported_events = 5'000'000;

/// The scenario as it is recorded: a client detects and controls the gaze, and there is no time for pictures.
Scenario recorded_scenario(Scenario scenario) {
  scenario.detectors.clear();
  scenario.frame_30hz.reset();
  scenario.gaze.detector = "remote";
  scenario.gaze.controller.controller = "remote";
  scenario.gaze.gate.gate = "remote";
  scenario.output.pictures = 0;
  scenario.output.video = false;
  return scenario;
}

/// A processor stays free for the client: threads that wait for each other lose more than they share.
std::int64_t served_threads(std::int64_t threads) {
  const auto processors = static_cast<std::int64_t>(std::thread::hardware_concurrency());
  return std::clamp<std::int64_t>(processors - 1, 1, threads);
}

/// Measures what this machine can do, and lowers what takes too long.
ServedWork fit_to_machine(Scenario& scenario) {
  const auto measured = [&](std::int64_t held_us) {
    return moving_speed(scenario.sim, static_cast<std::uint64_t>(scenario.seed),
                        static_cast<std::size_t>(scenario.run.threads), held_us);
  };
  const std::int64_t configured = scenario.sim.render.keyframe_samples;
  const MovingSpeed usual = measured(0);
  scenario.sim.render.keyframe_samples = bearable_samples(configured, usual.keyframe_ms);
  return served_work(usual, fits_usual(usual) ? MovingSpeed{} : measured(ImagePace::longest_us), configured);
}

/// Exchanges data with the ports first, then records the tick with the target of the gaze controller on them.
class ServeObserver final : public LoopObserver {
 public:
  ServeObserver(ServedPorts& served, RunRecorder& recorder) : served_(served), recorder_(recorder) {}
  void on_tick(const Tick& tick) override {
    served_.on_tick(tick);
    Tick with_target = tick;
    with_target.target_m = served_.target_m();
    recorder_.on_tick(with_target);
  }

 private:
  ServedPorts& served_;
  RunRecorder& recorder_;
};

/// The live page, if there is one.
class ServePage final : public LoopObserver {
 public:
  ServePage(LiveServer* server, bool endless, const Scenario& scenario, const SimRobot& robot,
            const ServedPorts& served, const Loop& loop)
      : robot_(robot), served_(served), camera_(scenario.sim.camera) {
    if (server == nullptr) return;
    feed_.emplace(*server,
                  LiveRun{.title = scenario.name,
                          .kind = "serve",
                          .size = camera_.size,
                          .both_eyes = scenario.sim.both_eyes(),
                          .duration_s = endless ? std::nullopt : std::optional(scenario.run.duration_s),
                          .head = head_model(scenario.sim.world.head),
                          .principal_px = Eigen::Vector2d(camera_.cx_px, camera_.cy_px)},
                  loop);
  }
  void on_tick(const Tick& tick) override {
    if (!feed_) return;
    feed_->set_truth(live_truth(robot_.truth(), camera_, served_.target_m()));
    feed_->on_tick(tick);
  }

 private:
  const SimRobot& robot_;
  const ServedPorts& served_;
  const Camera camera_;
  std::optional<LiveFeed> feed_;
};

/// Shows speed, load and clients.
class ServeProgress final : public LoopObserver {
 public:
  ServeProgress(Progress& progress, const Session& session, const PacedRobot& robot,
                const ServedPorts& served, const ImagePace& pace)
      : progress_(progress), session_(session), robot_(robot), served_(served), pace_(pace) {}
  void on_tick(const Tick& tick) override {
    const double t_s = static_cast<double>(tick.t_us) * 1e-6;
    progress_.show(t_s, [&] {
      const double wall_s = session_.wall_s();
      const double rate_hz =
          static_cast<double>(served_.commands() - commands_) / std::max(wall_s - shown_s_, 1e-3);
      commands_ = served_.commands();
      shown_s_ = wall_s;
      return fmt::format(
          "{:6.2f} s, {:.2f} x real time, {:.0f} % busy, {}, {} reader{}, {:.0f} commands per second", t_s,
          t_s / std::max(wall_s, 1e-9), 100.0 * std::min(robot_.busy_s() / std::max(wall_s, 1e-9), 1.0),
          pace_.summary(), served_.readers(), served_.readers() == 1 ? "" : "s", rate_hz);
    });
  }

 private:
  Progress& progress_;
  const Session& session_;
  const PacedRobot& robot_;
  const ServedPorts& served_;
  const ImagePace& pace_;
  std::int64_t commands_ = 0;
  double shown_s_ = 0.0;
};

/// Lets real time pass until a client is there. Throws RunError after an interrupt.
void wait_for_client(PacedRobot& paced, ServedPorts& served) {
  while (!interrupted() && !served.has_client()) {
    paced.idle(World::tick_us);
    served.idle();
  }
  if (interrupted()) throw RunError("interrupted before a client came");
  paced.restart();
}

/// serve.json: what the wall clock measured.
void write_serve_json(const std::filesystem::path& file, const ServedWork& work, const PacedRobot& paced,
                      const ImagePace& pace, const ServedPorts& served, const SimRobot& robot, double wall_s,
                      std::int64_t threads) {
  const auto json_of = [](const MovingSpeed& speed) {
    return nlohmann::json{{"simulated_s_per_s", speed.simulated_per_s()}, {"keyframe_ms", speed.keyframe_ms}};
  };
  nlohmann::json json = {{"schema", 1},
                         {"wall_s", wall_s},
                         {"busy_ratio", paced.busy_s() / std::max(wall_s, 1e-9)},
                         {"slipped_s", paced.slipped_s()},
                         {"latest_tick_ms", paced.latest_ms()},
                         {"longest_tick_ms", paced.longest_ms()},
                         {"packets", served.packets()},
                         {"threads", threads},
                         {"images",
                          {{"count", robot.images()},
                           {"interval_ms", pace.usual_interval_ms()},
                           {"held_share", pace.held_share()},
                           {"held_interval_ms", pace.held_interval_ms()},
                           {"longest_interval_ms", pace.longest_interval_ms()},
                           {"keyframe_samples", work.keyframe_samples}}},
                         {"moving_eyes", json_of(work.usual)}};
  if (work.lowered.wall_s > 0.0) json["moving_eyes_lowered"] = json_of(work.lowered);
  OutputFile out(file);
  out.write(json.dump(2) + "\n");
  out.commit();
}

std::unique_ptr<ServedPorts> open_ports(const ServeOptions& options, const Scenario& scenario,
                                        SimRobot& robot, ServedExternal::Log log) {
  if (!options.external.empty())
    return std::make_unique<ServedExternal>(options.external, robot, std::move(log));
#ifdef SACCADE_YARP
  return std::make_unique<ServedRobot>(options, scenario, robot, std::move(log));
#else
  (void)scenario;
  throw InputError("serve", "a saccade built without YARP", "--external ADDRESS, or one built with YARP");
#endif
}

/// Announces the end of the run, and answers for half a second clients that give the joints back.
void linger(ServedPorts& served) {
  constexpr int linger_ms = 500;
  served.announce_end();
  for (int ms = 0; ms < linger_ms; ++ms) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    served.linger();
  }
}

int serve_until_the_end(const ServeOptions& options, const Registry& registry) {
  Scenario scenario = read_scenario(options.scenario, options.assignments, options.seed, registry);
  SamplingConfig& sampling = scenario.sim.sampling;
  sampling.min_interval_ms =
      std::min(std::max(sampling.min_interval_ms, least_image_interval_ms), sampling.max_interval_ms);
  const std::filesystem::path folder =
      options.out.empty() ? std::filesystem::path("runs") / (scenario.name + "_served") : options.out;
  scenario.run.threads = served_threads(scenario.run.threads);
  set_rasterisers(scenario.run.threads);
  // Mesa's cache has a thread of the lowest priority: on a busy machine the end of the program would wait for it.
  ::setenv("MESA_SHADER_CACHE_DISABLE", "true", 0);
  use_small_stacks();
  // The simulation, the threads that draw for it, and above it the ports run with real-time priority, below deploy's ticks:
  // other programs, in this session or another, do not delay the robot. Those threads have the priority of the one that
  // starts them.
  std::optional<RealTime> urgent(std::in_place, serve_priority, LockMemory::no);
  const bool is_urgent = urgent->granted();
  const std::string scheduling = urgent->summary();
  const ServedWork work = fit_to_machine(scenario);
  SimRobot robot(scenario.sim, static_cast<std::uint64_t>(scenario.seed),
                 static_cast<std::size_t>(scenario.run.threads));
  urgent.reset();
  std::optional<LiveServer> server;  // before the folder is replaced: its address may be in use
  if (options.web) server.emplace(LiveServer::Config{.address = *options.web, .page = live_page()});
  const auto lock = start_run_folder(folder, options.force, registry.formats, "scenario.yaml",
                                     version_line() + ", " + SimRobot::simulator_version() + ", served; " +
                                         robot.gl_description() + "\n" + resolved_scenario(scenario));
  Progress progress(options.endless ? 0.0 : scenario.run.duration_s);
  LogFile log(folder / "log.txt", [&](const std::string& line) { progress.print_line(line); });
  catch_interrupts();
  if (scenario.latency.kind != LatencyKind::none)
    log.write(0, "warning: latency is not used: the client has latencies of its own");
  urgent.emplace(serve_ports_priority, LockMemory::no);
  std::unique_ptr<ServedPorts> served = open_ports(
      options, scenario, robot, [&](std::int64_t t_us, const std::string& text) { log.write(t_us, text); });
  urgent.reset();
  ImagePace pace(std::llround(sampling.min_interval_ms * 1e3));
  PacedRobot paced(
      robot, [&](std::int64_t late_us) { robot.hold_back_images(pace.next(late_us, robot.image_us())); });
  Loop loop(paced, scenario.calibration, {}, std::nullopt);
  const Scenario recorded = recorded_scenario(scenario);
  RunRecorder recorder(folder, recorded, robot, loop);
  ServeObserver observer(*served, recorder);
  Session session(paced, loop);
  ServeProgress show_progress(progress, session, paced, *served, pace);
  session.add_observer(observer);
  session.add_observer(show_progress);
  ServePage page(server ? &*server : nullptr, options.endless, scenario, robot, *served, loop);
  session.add_observer(page);
  if (server) progress.print_line("live page: " + server->link());

  log.write(0, scheduling);
  if (!is_urgent) {
    log.write(
        0, "warning: other programs of this machine can delay the robot, and then deploy stops the head: " +
               how_to_permit_real_time());
  }
  for (const std::string& line : work.lines) log.write(0, line);
  log.write(0, served->opened());
  // The threads that write files have it too: the simulation must not wait for an ordinary one that holds their queue.
  urgent.emplace(serve_priority, LockMemory::no);
  if (options.wait_for_client) {
    log.write(0, "the simulation waits for a client");
    try {
      wait_for_client(paced, *served);
    } catch (const RunError& error) {
      // A client that is halted in the middle of a message would make YARP wait for it: see close_within().
      close_within(
          longest_serve_close, [&] { served.reset(); }, error.what());
      throw;
    }
  }
  session.run(World::tick_us, options.endless ? std::numeric_limits<std::int64_t>::max()
                                              : std::llround(scenario.run.duration_s * 1e6));
  const double loop_s = session.wall_s();
  linger(*served);
  urgent.reset();
  progress.done();
  const std::int64_t t_us = robot.now_us();
  log.write(t_us, served->traffic());
  log.write(
      t_us,
      fmt::format("{:.0f} % busy; longest tick {:.1f} ms, latest tick {:.1f} ms, simulated time slipped by "
                  "{:.3f} s; {}",
                  100.0 * paced.busy_s() / std::max(loop_s, 1e-9), paced.longest_ms(), paced.latest_ms(),
                  paced.slipped_s(), pace.summary()));
  log.commit();
  write_serve_json(folder / run_file::serve, work, paced, pace, *served, robot, loop_s, scenario.run.threads);
  const Metrics metrics = recorder.finish(loop_s, settings_of(options.assignments));
  // Not finish_run_folder(): an interrupt is how such a run ends as planned.
  const double ran_s = static_cast<double>(t_us) * 1e-6;
  if (interrupted() && (ran_s > longest_report_s || metrics.event_count > most_reported_events)) {
    print_summary(metrics);
    fmt::print("no report, so that Ctrl-C ends at once after {:.0f} s: saccade report {} makes it\n", ran_s,
               folder.string());
  } else {
    report_run_folder(folder, metrics, registry.formats);
  }
  close_within(longest_serve_close, [&] { served->leave(); }, {});
  (void)served.release();  // its connections end with the program
  return 0;
}

}  // namespace

int serve(const ServeOptions& options, const Registry& registry) {
  const int status = serve_until_the_end(options, registry);
  // Threads of YARP still use what a return from main() destroys.
  std::fflush(nullptr);
  std::_Exit(status);
}

}  // namespace saccade
