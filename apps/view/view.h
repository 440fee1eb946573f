#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "apps/view/player_thread.h"
#include "apps/view/run_feed.h"
#include "config/registry.h"

namespace saccade {

/// The window of `saccade view` and `saccade run --view`. Used from one thread, the program's first.
class View {
 public:
  /// Opens the window. `name`: of what is shown, in the title and in the names of screenshots and videos, which are
  /// written to `pictures` (made when needed). `detectors`: those that a user can add.
  /// Throws InputError where there is no display.
  View(std::string name, std::filesystem::path pictures, DetectorRegistry detectors);
  ~View();
  View(const View&) = delete;
  View& operator=(const View&) = delete;

  /// What the user's key for saving writes: a function of the settings that returns YAML, and what it adds to the name of
  /// the file. Without it nothing can be saved.
  void set_save(std::function<std::string(const ViewSettings&)> yaml, std::string suffix);

  /// Shows a playback with its controls until the user closes the window or presses Ctrl-C. The window can be closed
  /// from the start, before there is a playback. Throws what ended the player's thread.
  void show(PlayerThread& player);

  /// Calls `run` in a thread of its own and shows the snapshots of its feed. The window takes at most a third of a core.
  /// Closing the window does not stop the run; the end of the run closes the window. Returns what `run` returns and
  /// throws what it throws.
  int show_run(const Scenario& scenario, const std::function<int(RunFeed&)>& run);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace saccade
