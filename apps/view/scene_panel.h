#pragma once

#include <memory>
#include <vector>

#include "apps/view/images.h"
#include "apps/view/layout.h"
#include "apps/view/snapshot.h"
#include "apps/view/view_state.h"
#include "apps/view/wall_clock.h"
#include "apps/view/window.h"

namespace saccade {

/// The scene from outside; for a recording without a world its events in image and time. It is expensive, so that it is
/// drawn less often than the other panels.
class ScenePanel {
 public:
  explicit ScenePanel(Window& window) : window_(window), texture_(window, true) {}

  /// `min_period_s`: at least so long between two drawings while the loop moves.
  void draw(const Area& area, const Snapshot& snapshot, ViewState& state, double min_period_s);
  /// A new snapshot has come.
  void invalidate() { stale_ = true; }
  /// Whether the panel shows something older than the snapshot.
  [[nodiscard]] bool stale() const { return stale_; }
  /// Processor time of each drawing, s.
  [[nodiscard]] const std::vector<double>& drawing_s() const { return drawing_s_; }

 private:
  void turn(const Area& at, ViewState& state);
  void draw_scene(const Snapshot& snapshot, const SceneView& view, ImageSize size);

  Window& window_;
  Window::Texture texture_;
  std::shared_ptr<const mjModel> model_;  // of renderer_, which refers to it
  std::unique_ptr<SceneRenderer> renderer_;
  RgbImage rgb_;
  bool stale_ = true;
  WallClock::time_point drawn_;
  double took_s_ = 0.0;
  std::vector<double> drawing_s_;
};

/// Processor time of the calling thread, s.
[[nodiscard]] double processor_s();

}  // namespace saccade
