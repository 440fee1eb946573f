#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <span>

#include "apps/config/scenario.h"
#include "apps/session/played.h"
#include "apps/view/picture.h"
#include "sim/sim_robot.h"

namespace saccade {

/// Notes a loop's ticks and fills pictures of it. Its memory does not grow; a copy goes on from where it was taken.
class Watcher {
 public:
  Watcher(const Camera& camera, Eye eye, std::int64_t start_us, std::int64_t end_us);

  /// `driver` indexes the loop's detectors.
  void see(const Tick& tick, const ShownTruth& truth, const Loop& loop, std::size_t driver);
  /// Other detectors said this at the newest tick.
  void see_instead(std::vector<Seen> seen, std::size_t driver);
  /// Everything that a loop tells; not grey, scene, playing, seeking, speed, handled and problem.
  void fill(Picture& picture, const Loop& loop) const;

  /// One tick's part of what detectors get, to start a new one with.
  struct Past {
    std::int64_t t_us = 0;
    std::vector<Event> events;
    std::optional<HeadState> head;
  };
  /// Of the last Picture::events_us. Shared, so that a copy costs little.
  using Pasts = std::deque<std::shared_ptr<const Past>>;
  [[nodiscard]] const Pasts& pasts() const { return pasts_; }
  [[nodiscard]] std::span<const Seen> seen() const { return seen_; }
  [[nodiscard]] std::int64_t now_us() const { return now_us_; }
  [[nodiscard]] std::int64_t start_us() const { return start_us_; }
  [[nodiscard]] std::int64_t end_us() const { return end_us_; }

 private:
  Camera camera_;
  std::uint8_t eye_;
  std::int64_t start_us_, now_us_, end_us_;
  Pasts pasts_;
  std::deque<PlotSample> samples_;
  std::vector<Seen> seen_;
  std::size_t driver_ = 0;
  ShownTruth truth_;
  GazePhase phase_ = GazePhase::none;
};

/// A loop that a person plays with. Used from one thread. Its ticks are 1 ms.
class Play {
 public:
  static constexpr std::int64_t tick_us = 1'000;

  virtual ~Play() = default;
  [[nodiscard]] virtual const Watcher& watcher() const = 0;
  /// The next tick; false, and nothing happens, at the end.
  virtual bool tick() = 0;
  /// To an instant before t_us from where ticks lead to what they led to before; the later, the better.
  virtual void go_back(std::int64_t t_us) = 0;
  /// Acts from now on. A detector that is new or other than before starts with the events of the last
  /// Picture::events_us. Throws InputError, and nothing changes.
  virtual void apply(const ViewSettings& settings) = 0;
  virtual void fill(Picture& picture) = 0;

  [[nodiscard]] virtual const ViewSettings& settings() const = 0;
  /// Events of the whole recording in equal parts of its time; empty where that is not known.
  [[nodiscard]] virtual std::vector<float> overview() const = 0;
};

/// The simulated robot in its scenario. It goes back by starting again.
[[nodiscard]] std::unique_ptr<Play> play_scenario(const Scenario& scenario);

/// A recording, or a run folder with its camera, joints, truth and world. `named`: its detectors, of which `driver` is
/// looked at first.
/// It goes back to copies of its detectors that it keeps on the way.
[[nodiscard]] std::unique_ptr<Play> play_recording(const ReadOptions& options,
                                                   const std::filesystem::path& truth,
                                                   const NamedDetectors& named, const std::string& driver);

/// What a window shows of the truth of a simulated run's tick.
[[nodiscard]] ShownTruth shown_truth(const SimRobot& robot, const Camera& camera, const Tick& tick);
/// The eye's image of a simulated robot, and its world.
void fill_from(const SimRobot& robot, Picture& picture);

/// The detectors of a scenario or of a command line, the driver the one with that name.
[[nodiscard]] ViewSettings view_settings(const NamedDetectors& named, const std::string& driver);

}  // namespace saccade
