#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <string>

#include "apps/view/player.h"

namespace saccade {

/// The window of `saccade view` and of `saccade run --view`: what the robot sees while it happens. Used from one
/// thread, the program's first.
class View {
 public:
  /// Opens the window. `name` is in its title and in the names of its screenshots and videos, which go into
  /// `pictures` (made when needed). Throws InputError where there is no display.
  View(std::string name, std::filesystem::path pictures);
  ~View();
  View(const View&) = delete;
  View& operator=(const View&) = delete;

  /// Shows what the player plays, and lets a person play, until the window is closed or Ctrl-C.
  void show(Player& player);

  /// A run's pictures on their way to the window.
  class Feed {
   public:
    /// The run's thread, after each tick; costs nothing where no picture is wanted.
    void see(const Tick& tick, const SimRobot& robot, const Loop& loop);
    /// Before robot and loop go: nothing of them is looked at afterwards.
    void close();

   private:
    friend class View;
    explicit Feed(const Scenario& scenario);
    Camera camera_;
    std::string driver_;
    Watcher watcher_;
    Mailbox mailbox_;
    std::mutex drawing_;
    std::atomic<bool> closed_ = false;
  };
  /// Does `run` in a thread of its own and shows what it feeds, at a rate that leaves it the processor. A window that
  /// is closed does not stop it. Gives what `run` gives and throws what it throws.
  int show_run(const Scenario& scenario, const std::function<int(Feed&)>& run);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace saccade
