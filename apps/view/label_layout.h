#pragma once

#include <algorithm>

#include "apps/view/layout.h"

namespace saccade {

/// The places of the panels in the window of `saccade label`, of width x height px. The image gets what the others leave.
struct LabelLayout {
  Area bar, image, list, keys, timeline;

  LabelLayout(int width, int height) {
    constexpr float gap = ViewLayout::gap;
    constexpr float side = 300.0F;
    constexpr float keys_height = 400.0F;
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

  /// The part of a panel below its caption.
  [[nodiscard]] static Area below_caption(const Area& panel) {
    return {panel.x, panel.y + ViewLayout::caption, panel.width, panel.height - ViewLayout::caption};
  }
  /// The part of the timeline that shows time from start to end.
  [[nodiscard]] Area time_strip() const {
    return {timeline.x + 8.0F, timeline.y + 6.0F, timeline.width - 16.0F, timeline.height - 26.0F};
  }
};

/// An enlarged part of an image in a panel.
class ImageZoom {
 public:
  /// The place of the whole image, of which the panel shows a part: centred as ViewLayout::fit() places it, enlarged and
  /// moved.
  [[nodiscard]] Area place(const Area& panel, ImageSize image) const {
    const Area all = ViewLayout::fit(panel, image);
    const Area frame = LabelLayout::below_caption(panel);
    return {frame.x + (all.x - frame.x) * factor_ + x_, frame.y + (all.y - frame.y) * factor_ + y_,
            all.width * factor_, all.height * factor_};
  }
  /// Enlarges by `factor` around a point of the panel, px from the top left of what is below its caption. At the original
  /// size the image is back in its place.
  void scale(float factor, float x, float y) {
    const float wanted = std::clamp(factor_ * factor, 1.0F, 40.0F);
    x_ = x - (x - x_) * wanted / factor_;
    y_ = y - (y - y_) * wanted / factor_;
    factor_ = wanted;
    if (factor_ == 1.0F) x_ = y_ = 0.0F;
  }
  void pan(float x, float y) {
    if (factor_ == 1.0F) return;
    x_ += x;
    y_ += y;
  }

 private:
  float factor_ = 1.0F;
  float x_ = 0.0F, y_ = 0.0F;
};

}  // namespace saccade
