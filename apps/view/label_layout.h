#pragma once

#include "apps/view/layout.h"

namespace saccade {

/// The places of the panels in the window of `saccade label`, of width x height px. The image gets what the others leave.
struct LabelLayout {
  Area bar, image, list, keys, timeline;

  LabelLayout(int width, int height) {
    constexpr float gap = ViewLayout::gap;
    constexpr float side = 300.0F;
    constexpr float keys_height = 446.0F;
    const auto w = static_cast<float>(width);
    const auto h = static_cast<float>(height);
    bar = {gap, gap, w - 2 * gap, 38.0F};
    timeline = {gap, h - 56.0F - gap, w - 2 * gap, 56.0F};
    const float top = bar.y + bar.height + gap;
    const float between = timeline.y - gap - top;
    image = {gap, top, w - side - 3 * gap, between};
    keys = {w - side - gap, timeline.y - gap - keys_height, side, keys_height};
    list = {keys.x, top, side, keys.y - gap - top};
  }

  /// The part of the timeline that shows time from start to end.
  [[nodiscard]] Area time_strip() const {
    return {timeline.x + 8.0F, timeline.y + 6.0F, timeline.width - 16.0F, timeline.height - 26.0F};
  }
};

}  // namespace saccade
