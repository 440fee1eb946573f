#include "apps/view/play.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "apps/config/scenario.h"
#include "apps/session/scenario_loop.h"
#include "sim/lab.h"

namespace saccade {
namespace {

constexpr double deg_per_rad = 180.0 / std::numbers::pi;
constexpr std::int64_t annotated_us = 20'000;  ///< for how long an annotated circle is shown

float angle_deg(const Eigen::Isometry3d& root_from_cam, const Eigen::Vector3d& ball_m) {
  const Eigen::Vector3d to_ball = ball_m - root_from_cam.translation();
  const Eigen::Vector3d axis = root_from_cam.linear().col(2);
  return static_cast<float>(deg_per_rad * std::atan2(axis.cross(to_ball).norm(), axis.dot(to_ball)));
}

bool same(const DetectorConfig& a, const DetectorConfig& b) {
  return resolved_detectors({{"", a}}) == resolved_detectors({{"", b}});
}

/// The detectors that settings ask for, and what they say at the newest tick.
struct Renewed {
  std::vector<LoopDetector> detectors;
  std::vector<Seen> seen;
  std::size_t driver = 0;
};

/// Where `driver` is among those that are on.
std::size_t place_of_driver(const ViewSettings& settings) {
  std::size_t place = 0;
  for (std::size_t i = 0; i < settings.driver; ++i) place += settings.detectors[i].on ? 1 : 0;
  return place;
}

/// A detector that has seen the last events.
Seen start(const std::string& name, Detector& detector, const Watcher& watcher, const MountedCamera& camera,
           Eye eye) {
  Seen seen{name, {}, detector.threshold()};
  for (const auto& past : watcher.pasts()) {
    std::optional<CameraMotion> motion;
    if (past->head && is_finite(*past->head))
      motion = camera_motion(*past->head, eye, camera.mount.eye_from_camera());
    detector.process(past->events, motion ? &*motion : nullptr);
    detector.advance_to(past->t_us, motion ? &*motion : nullptr);
    seen.tick.estimate = detector.estimate();
    seen.tick.observed = seen.tick.estimate.valid && (!past->events.empty() || seen.tick.estimate.held);
  }
  return seen;
}

Renewed renew(const ViewSettings& settings, const ViewSettings& before, const Loop& loop,
              const Watcher& watcher, const MountedCamera& camera, Eye eye) {
  Renewed renewed;
  renewed.driver = place_of_driver(settings);
  for (const ViewSettings::NamedDetector& wanted : settings.detectors) {
    if (!wanted.on) continue;
    const auto old = std::ranges::find_if(before.detectors, [&](const auto& other) {
      return other.on && other.name == wanted.name && same(other.config, wanted.config);
    });
    if (old != before.detectors.end()) {
      const auto named = [&](const auto& other) { return other.name == wanted.name; };
      const auto it = std::ranges::find_if(loop.detectors(), named);
      SACCADE_CHECK(it != loop.detectors().end());
      renewed.detectors.push_back({wanted.name, it->detector->copy()});
      const auto said = std::ranges::find_if(watcher.seen(), named);
      renewed.seen.push_back(said != watcher.seen().end() ? *said
                                                          : Seen{wanted.name, {}, it->detector->threshold()});
      continue;
    }
    auto detector = make_detector(wanted.config, camera.camera);
    renewed.seen.push_back(start(wanted.name, *detector, watcher, camera, eye));
    renewed.detectors.push_back({wanted.name, std::move(detector)});
  }
  return renewed;
}

// ---- the simulated robot ---------------------------------------------------------------------------

class SimPlay final : public Play {
 public:
  explicit SimPlay(const Scenario& scenario)
      : scenario_(scenario),
        settings_(view_settings(scenario.detectors, scenario.gaze.detector)),
        watcher_(fresh_watcher()) {
    if (moves_head()) settings_.controller = scenario.gaze.controller;
    if (follows()) settings_.gate = scenario.gaze.gate;
    restart();
  }

  [[nodiscard]] const Watcher& watcher() const override { return watcher_; }

  bool tick() override {
    const std::int64_t t_us = watcher_.now_us() + tick_us;
    if (t_us > watcher_.end_us()) return false;
    Observer observer([this](const Tick& tick) {
      watcher_.see(tick, shown_truth(*robot_, scenario_.sim.camera, tick), *loop_,
                   place_of_driver(settings_));
    });
    loop_->tick(t_us, observer);
    return true;
  }

  void go_back(std::int64_t t_us) override {
    if (t_us <= watcher_.now_us()) restart();
  }

  void apply(const ViewSettings& settings) override {
    Renewed renewed = renew(settings, settings_, *loop_, watcher_, scenario_.calibration, Eye::left);
    std::unique_ptr<GazeController> controller;
    std::unique_ptr<GazeGate> gate;
    const auto text = [&](const ViewSettings& of) {
      Scenario copy = scenario_;
      if (of.controller) copy.gaze.controller = *of.controller;
      if (of.gate) copy.gaze.gate = *of.gate;
      return resolved_scenario(copy);
    };
    const bool other_driver =
        settings.detectors[settings.driver].name != settings_.detectors[settings_.driver].name;
    if (text(settings) != text(settings_) || other_driver) {
      if (settings.controller) controller = make_gaze_controller(*settings.controller, robot_->limits());
      if (settings.gate) gate = make_gate(*settings.gate);
    }
    loop_->set_detectors(std::move(renewed.detectors),
                         follows() ? std::optional(renewed.driver) : std::nullopt);
    if (controller) loop_->set_controller(std::move(controller));
    if (gate) loop_->set_gate(std::move(gate));
    watcher_.see_instead(std::move(renewed.seen), renewed.driver);
    settings_ = settings;
  }

  void fill(Picture& picture) override {
    watcher_.fill(picture, *loop_);
    fill_from(*robot_, picture);
  }

  [[nodiscard]] const ViewSettings& settings() const override { return settings_; }
  [[nodiscard]] std::vector<float> overview() const override { return {}; }

 private:
  class Observer final : public LoopObserver {
   public:
    explicit Observer(std::function<void(const Tick&)> see) : see_(std::move(see)) {}
    void on_tick(const Tick& tick) override { see_(tick); }

   private:
    std::function<void(const Tick&)> see_;
  };

  [[nodiscard]] bool follows() const { return scenario_.gaze.detector != "none"; }
  [[nodiscard]] bool moves_head() const {
    return follows() || scenario_.gaze.controller.controller == "script";
  }
  [[nodiscard]] Watcher fresh_watcher() const {
    return {scenario_.sim.camera, Eye::left, 0, std::llround(scenario_.run.duration_s * 1e3) * tick_us};
  }

  void restart() {
    Scenario scenario = scenario_;
    scenario.detectors.clear();
    for (const auto& named : settings_.detectors) {
      if (named.on) scenario.detectors.emplace_back(named.name, named.config);
    }
    if (follows()) scenario.gaze.detector = settings_.detectors[settings_.driver].name;
    if (settings_.controller) scenario.gaze.controller = *settings_.controller;
    if (settings_.gate) scenario.gaze.gate = *settings_.gate;
    loop_.reset();
    // The window draws with the model of the first robot for as long as there is a window.
    auto robot = std::make_unique<SimRobot>(scenario.sim, static_cast<std::uint64_t>(scenario.seed));
    if (!first_robot_) first_robot_ = std::move(robot_);
    robot_ = std::move(robot);
    loop_.emplace(make_loop(scenario, *robot_));
    watcher_ = fresh_watcher();
  }

  Scenario scenario_;
  ViewSettings settings_;
  Watcher watcher_;
  std::unique_ptr<SimRobot> first_robot_, robot_;
  std::optional<Loop> loop_;
};

// ---- a recording -----------------------------------------------------------------------------------

/// Events that are in memory, as a file.
class MemoryReader final : public EventReader {
 public:
  MemoryReader(std::span<const Event> events, ImageSize size) : events_(events), size_(size) {}
  std::size_t read(std::vector<Event>& events, std::size_t max_events) override {
    const auto block = events_.first(std::min(max_events, events_.size()));
    events.insert(events.end(), block.begin(), block.end());
    events_ = events_.subspan(block.size());
    return block.size();
  }
  [[nodiscard]] std::optional<ImageSize> image_size() const override { return size_; }
  [[nodiscard]] std::string format() const override { return "memory"; }

 private:
  std::span<const Event> events_;
  ImageSize size_;
};

class RecordingPlay final : public Play, private LoopObserver {
 public:
  RecordingPlay(const ReadOptions& options, const std::filesystem::path& truth, const NamedDetectors& named,
                const std::string& driver)
      : settings_(view_settings(named, driver)) {
    Played played = open_played(options, truth);
    eye_ = played.eye;
    camera_ = played.camera;
    annotated_ = played.chances == Chances::annotated;
    truth_ = std::move(played.truth);
    std::int64_t start_us = 0;
    {
      ReplayRobot robot(open_event_file(played.events, played.read), std::move(played.head));
      start_us = robot.now_us();
      camera_.camera.size = robot.image_size();
      has_head_ = robot.head() != nullptr;
      if (has_head_) start_us -= tick_us;  // the first row is of a run's first tick
      for (std::int64_t t_us = robot.now_us(); robot.wait_until(t_us) == PortStatus::ok; t_us += 100'000) {
        if (robot.read_until(t_us, events_) == PortStatus::ended) break;
      }
    }
    if (events_.empty()) {
      throw InputError(options.recording.string(), "no events of a camera",
                       "a recording with some; saccade info tells what it holds");
    }
    folder_ = is_run_folder(options.recording) ? options.recording : "";
    std::int64_t last_us = events_.back().t_us;
    if (!folder_.empty()) read_run_folder(last_us);
    const std::int64_t ticks = std::max<std::int64_t>(1, (last_us - start_us + tick_us - 1) / tick_us);
    kept_.emplace_back(Watcher(camera_.camera, eye_, start_us, start_us + ticks * tick_us),
                       std::vector<LoopDetector>{});
    start_fresh();
    const auto bytes = static_cast<std::int64_t>(camera_.camera.size.pixels()) * 90 *
                       static_cast<std::int64_t>(named.size());
    most_kept_ = static_cast<std::size_t>(std::clamp<std::int64_t>((256 << 20) / bytes, 3, 64));
    restore(kept_.front());
  }

  [[nodiscard]] const Watcher& watcher() const override { return watcher_; }

  bool tick() override {
    const std::int64_t t_us = watcher_.now_us() + tick_us;
    if (t_us > watcher_.end_us()) return false;
    loop_->tick(t_us, *this);
    if (watcher_.now_us() != t_us) return false;
    if (t_us >= kept_.back().watcher.now_us() + spacing_us_) keep();
    return true;
  }

  void go_back(std::int64_t t_us) override {
    const auto last = std::find_if(kept_.rbegin(), kept_.rend(),
                                   [&](const Kept& kept) { return kept.watcher.now_us() < t_us; });
    const Kept& best = last != kept_.rend() ? *last : kept_.front();
    if (watcher_.now_us() < t_us && watcher_.now_us() >= best.watcher.now_us()) return;
    restore(best);
  }

  void apply(const ViewSettings& settings) override {
    Renewed renewed = renew(settings, settings_, *loop_, watcher_, camera_, eye_);
    loop_->set_detectors(std::move(renewed.detectors), std::nullopt);
    watcher_.see_instead(std::move(renewed.seen), renewed.driver);
    const auto running = [](const ViewSettings& of) {
      NamedDetectors on;
      for (const auto& named : of.detectors) {
        if (named.on) on.emplace_back(named.name, named.config);
      }
      return resolved_detectors(on);
    };
    const bool others = running(settings) != running(settings_);
    settings_ = settings;
    if (others) start_fresh();
  }

  void fill(Picture& picture) override {
    watcher_.fill(picture, *loop_);
    picture.grey.clear();
    if (!world_) return;
    picture.model = &world_->model();
    if (!picture.scene) picture.scene.reset(mj_makeData(&world_->model()));
    if (!picture.scene) throw RunError("MuJoCo has no memory for a picture of the world");
    JointVector joints = JointVector::Zero();
    if (!watcher_.pasts().empty() && watcher_.pasts().back()->head)
      joints = watcher_.pasts().back()->head->position_rad;
    world_->pose(watcher_.now_us(), joints, *picture.scene);
  }

  [[nodiscard]] const ViewSettings& settings() const override { return settings_; }
  [[nodiscard]] std::vector<float> overview() const override {
    std::vector<float> parts(600, 0.0F);
    const auto start_us = static_cast<double>(watcher_.start_us());
    const double span_us = static_cast<double>(watcher_.end_us()) - start_us;
    for (const Event& event : events_) {
      const double share = (static_cast<double>(event.t_us) - start_us) / span_us;
      const auto part = static_cast<std::size_t>(share * static_cast<double>(parts.size()));
      parts[std::min(part, parts.size() - 1)] += 1.0F;
    }
    return parts;
  }

 private:
  /// Where it can go back to.
  struct Kept {
    Kept(Watcher its_watcher, std::vector<LoopDetector> its_detectors)
        : watcher(std::move(its_watcher)), detectors(std::move(its_detectors)) {}
    Kept(Kept&&) = default;
    Kept& operator=(Kept&&) = default;

    Watcher watcher;
    std::vector<LoopDetector> detectors;
  };

  void on_tick(const Tick& tick) override {
    watcher_.see(tick, truth_at(tick.t_us), *loop_, place_of_driver(settings_));
  }

  /// The world and the gaze of a run folder; later rows than `last_us` make the recording longer.
  void read_run_folder(std::int64_t& last_us) {
    const auto read = [&](const char* name, auto& rows) {
      using Rows = std::remove_reference_t<decltype(rows)>;
      if (eye_ == Eye::left && std::filesystem::exists(folder_ / name))
        rows = read_table<typename Rows::value_type>(folder_ / name);
    };
    read("eye.csv", eye_rows_);
    read("gaze.csv", gaze_rows_);
    if (!gaze_rows_.empty()) last_us = std::max(last_us, gaze_rows_.back().t_us);
    if (!has_head_ || !std::filesystem::exists(folder_ / "scenario.yaml")) return;
    try {
      const Scenario scenario = read_scenario(folder_ / "scenario.yaml", {}, std::nullopt);
      const auto seed = static_cast<std::uint64_t>(scenario.seed);
      world_ = std::make_unique<World>(scenario.sim.world, lab_mjcf(scenario.sim.lab, seed), seed);
      paint_lab_textures(world_->model(), scenario.sim.lab, seed);
    } catch (const InputError&) {
      world_.reset();  // of another version, whose world is not known any more
    }
  }

  template <class Row>
  static const Row* row_at(const std::vector<Row>& rows, std::int64_t t_us, std::int64_t not_older_us) {
    const auto after = std::ranges::upper_bound(rows, t_us, {}, &Row::t_us);
    if (after == rows.begin() || std::prev(after)->t_us < t_us - not_older_us) return nullptr;
    return &*std::prev(after);
  }

  [[nodiscard]] ShownTruth truth_at(std::int64_t t_us) const {
    ShownTruth shown;
    const TruthRow* truth = row_at(truth_, t_us, annotated_ ? annotated_us : 0);
    if (truth != nullptr && truth->visible > 0.0 && std::isfinite(truth->circle.x_px))
      shown.circle = truth->circle;
    const EyeRow* eye = row_at(eye_rows_, t_us, 0);
    if (eye == nullptr) return shown;
    shown.root_from_cam = eye->root_from_left_cam();
    if (truth != nullptr && truth->position_m.allFinite())
      shown.gaze_error_deg = angle_deg(*shown.root_from_cam, truth->position_m);
    const GazeRow* gaze = row_at(gaze_rows_, t_us, 0);
    if (gaze != nullptr && gaze->target_m.allFinite()) {
      shown.target_m = gaze->target_m;
      shown.target_px = camera_.camera.project(shown.root_from_cam->inverse() * gaze->target_m);
    }
    return shown;
  }

  static std::vector<LoopDetector> copies(std::span<const LoopDetector> detectors) {
    std::vector<LoopDetector> copied;
    for (const LoopDetector& detector : detectors)
      copied.push_back({detector.name, detector.detector->copy()});
    return copied;
  }

  /// Forgets the detectors that were kept; the start gets new ones when it is gone back to.
  void start_fresh() {
    kept_.erase(kept_.begin() + 1, kept_.end());
    kept_.front().detectors.clear();
    fresh_ = false;
  }

  void keep() {
    if (!fresh_) return;
    kept_.emplace_back(watcher_, copies(loop_->detectors()));
    if (kept_.size() <= most_kept_) return;
    std::vector<Kept> fewer;
    for (std::size_t i = 0; i < kept_.size(); i += 2) fewer.push_back(std::move(kept_[i]));
    kept_ = std::move(fewer);
    spacing_us_ *= 2;
  }

  void restore(const Kept& kept) {
    loop_.reset();
    watcher_ = kept.watcher;
    const std::int64_t now_us = watcher_.now_us();
    const auto next = now_us == watcher_.start_us()
                          ? events_.begin()
                          : std::ranges::upper_bound(events_, now_us, {}, &Event::t_us);
    std::optional<RecordedHead> head;
    if (has_head_) head.emplace(RecordedHead{TableReader<JointsRow>(folder_ / "joints.csv"), {}});
    robot_ = std::make_unique<ReplayRobot>(
        std::make_unique<MemoryReader>(std::span<const Event>(next, events_.end()), camera_.camera.size),
        std::move(head));
    robot_->wait_until(now_us);
    std::vector<LoopDetector> detectors = copies(kept.detectors);
    if (detectors.empty()) {
      for (const auto& named : settings_.detectors) {
        if (named.on) detectors.push_back({named.name, make_detector(named.config, camera_.camera)});
      }
    }
    loop_.emplace(*robot_, camera_, std::move(detectors), std::nullopt, eye_);
    fresh_ = true;
  }

  ViewSettings settings_;
  std::filesystem::path folder_;  // of a run; empty for a bare recording
  Eye eye_ = Eye::left;
  MountedCamera camera_;
  bool has_head_ = false;
  std::vector<Event> events_;
  bool annotated_ = false;
  std::vector<TruthRow> truth_;
  std::vector<EyeRow> eye_rows_;
  std::vector<GazeRow> gaze_rows_;
  std::unique_ptr<World> world_;
  std::vector<Kept> kept_;  // sorted by time; the first is the start
  std::size_t most_kept_ = 3;
  std::int64_t spacing_us_ = 250'000;
  bool fresh_ = true;  // the detectors are what they would be if they had run from the start
  Watcher watcher_{Camera{}, Eye::left, 0, 0};
  std::unique_ptr<ReplayRobot> robot_;
  std::optional<Loop> loop_;
};

}  // namespace

// ---- Watcher ---------------------------------------------------------------------------------------

Watcher::Watcher(const Camera& camera, Eye eye, std::int64_t start_us, std::int64_t end_us)
    : camera_(camera),
      eye_(static_cast<std::uint8_t>(eye)),
      start_us_(start_us),
      now_us_(start_us),
      end_us_(end_us) {}

void Watcher::see(const Tick& tick, const ShownTruth& truth, const Loop& loop, std::size_t driver) {
  now_us_ = tick.t_us;
  truth_ = truth;
  phase_ = tick.phase;
  driver_ = driver;
  auto past = std::make_shared<Past>(Past{tick.t_us, {}, tick.head});
  std::ranges::copy_if(tick.events, std::back_inserter(past->events),
                       [&](const Event& event) { return event.camera == eye_; });
  seen_.clear();
  for (std::size_t i = 0; i < tick.detectors.size(); ++i) {
    const LoopDetector& detector = loop.detectors()[i];
    seen_.push_back({detector.name, tick.detectors[i], detector.detector->threshold()});
  }

  PlotSample sample;
  sample.t_us = tick.t_us;
  sample.events = static_cast<float>(past->events.size());
  if (truth.circle)
    sample.truth_px = {static_cast<float>(truth.circle->x_px), static_cast<float>(truth.circle->y_px)};
  if (driver < seen_.size()) {
    const Seen& seen = seen_[driver];
    sample.threshold = static_cast<float>(seen.threshold);
    if (seen.tick.observed) {
      const Estimate& estimate = seen.tick.estimate;
      sample.score = static_cast<float>(estimate.score);
      if (estimate.score >= seen.threshold)
        sample.found_px = {static_cast<float>(estimate.circle.x_px),
                           static_cast<float>(estimate.circle.y_px)};
    }
  }
  sample.gaze_error_deg = truth.gaze_error_deg;
  if (tick.head) {
    for (std::size_t j = 0; j < joint_count; ++j) {
      sample.joints_deg[j] =
          static_cast<float>(deg_per_rad * tick.head->position_rad[static_cast<Eigen::Index>(j)]);
    }
  }
  samples_.push_back(sample);
  pasts_.push_back(std::move(past));
  while (samples_.front().t_us <= now_us_ - Picture::plot_us) samples_.pop_front();
  while (pasts_.front()->t_us <= now_us_ - Picture::events_us) pasts_.pop_front();
}

void Watcher::see_instead(std::vector<Seen> seen, std::size_t driver) {
  seen_ = std::move(seen);
  driver_ = driver;
}

void Watcher::fill(Picture& picture, const Loop& loop) const {
  picture.start_us = start_us_;
  picture.now_us = now_us_;
  picture.end_us = end_us_;
  picture.camera = camera_;
  picture.events.clear();
  for (const auto& past : pasts_)
    picture.events.insert(picture.events.end(), past->events.begin(), past->events.end());
  picture.seen = seen_;
  picture.driver = driver_;
  picture.truth = truth_;
  picture.phase = phase_;
  picture.samples.assign(samples_.begin(), samples_.end());
  picture.hough.resize(static_cast<std::size_t>(camera_.size.pixels()));
  if (driver_ >= loop.detectors().size() || !loop.detectors()[driver_].detector->hough_space(picture.hough))
    picture.hough.clear();
}

// ---- what is shared --------------------------------------------------------------------------------

std::unique_ptr<Play> play_scenario(const Scenario& scenario) { return std::make_unique<SimPlay>(scenario); }

std::unique_ptr<Play> play_recording(const ReadOptions& options, const std::filesystem::path& truth,
                                     const NamedDetectors& named, const std::string& driver) {
  return std::make_unique<RecordingPlay>(options, truth, named, driver);
}

ShownTruth shown_truth(const SimRobot& robot, const Camera& camera, const Tick& tick) {
  const SimTruth& truth = robot.truth();
  ShownTruth shown;
  if (truth.left.visible > 0.0) shown.circle = truth.left.circle;
  shown.root_from_cam = truth.left.root_from_cam;
  shown.gaze_error_deg = angle_deg(truth.left.root_from_cam, truth.ball_m);
  shown.target_m = tick.target_m;
  if (tick.target_m) shown.target_px = camera.project(truth.left.root_from_cam.inverse() * *tick.target_m);
  return shown;
}

void fill_from(const SimRobot& robot, Picture& picture) {
  const std::span<const float> image = robot.left_eye().image();
  picture.grey.resize(image.size());
  std::ranges::transform(image, picture.grey.begin(), [](float grey) {
    return static_cast<std::uint8_t>(std::lround(std::clamp(grey, 0.0F, 255.0F)));
  });
  const World& world = robot.world();
  if (picture.model == nullptr) picture.model = &world.model();
  if (!picture.scene) picture.scene.reset(mj_makeData(&world.model()));
  if (!picture.scene) throw RunError("MuJoCo has no memory for a picture of the world");
  mj_copyData(picture.scene.get(), &world.model(), &world.data());
}

ViewSettings view_settings(const NamedDetectors& named, const std::string& driver) {
  ViewSettings settings;
  for (std::size_t i = 0; i < named.size(); ++i) {
    settings.detectors.push_back({named[i].first, named[i].second, true});
    if (named[i].first == driver) settings.driver = i;
  }
  return settings;
}

}  // namespace saccade
