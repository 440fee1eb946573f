#pragma once

#include <algorithm>
#include <cmath>

#include "core/event.h"

namespace saccade {

/// A rectangle in the window, px from its top left corner.
struct Area {
  float x = 0.0F, y = 0.0F, width = 0.0F, height = 0.0F;
};

/// The places of the panels in a window of width x height px. Designed for 1280 x 720; images and plots get the rest.
struct ViewLayout {
  static constexpr float gap = 6.0F;
  static constexpr float caption = 24.0F;  ///< height of a panel's caption
  Area bar, scene, eye, hough, detectors, settings, plots, timeline;

  ViewLayout(int width, int height) {
    const auto w = static_cast<float>(width);
    const auto h = static_cast<float>(height);
    const float side = std::clamp(0.21F * w, 268.0F, 400.0F);
    bar = {gap, gap, w - 2 * gap, 38.0F};
    timeline = {gap, h - 56.0F - gap, w - 2 * gap, 56.0F};
    const float top = bar.y + bar.height + gap;
    const float height_left = timeline.y - gap - top;
    const float row = std::round(0.66F * height_left);
    const float left = w - side - 3 * gap;  // width of all but the settings
    const float eye_side = std::min(row - caption, 0.4F * left);
    const float hough_side = std::clamp(0.6F * eye_side, 200.0F, std::max(200.0F, row - caption - 130.0F));
    const float scene_side = left - eye_side - hough_side - 2 * gap;
    scene = {gap, top, scene_side, row};
    eye = {scene.x + scene.width + gap, top, eye_side, row};
    const float third = eye.x + eye.width + gap;
    hough = {third, top, hough_side, hough_side + caption};
    detectors = {third, top + hough.height + gap, hough_side, row - hough.height - gap};
    settings = {third + hough_side + gap, top, side, height_left};
    plots = {gap, top + row + gap, left, height_left - row - gap};
  }

  /// The place of an image of that size in a panel: below the caption, as large as possible, centred.
  [[nodiscard]] static Area fit(const Area& panel, ImageSize shape) {
    const float height = panel.height - caption;
    const float scale =
        std::min(panel.width / static_cast<float>(shape.width), height / static_cast<float>(shape.height));
    const float w = scale * static_cast<float>(shape.width);
    const float h = scale * static_cast<float>(shape.height);
    return {panel.x + 0.5F * (panel.width - w), panel.y + caption + 0.5F * (height - h), w, h};
  }
  /// The part of a panel below its caption.
  [[nodiscard]] static Area below_caption(const Area& panel) {
    return {panel.x, panel.y + caption, panel.width, panel.height - caption};
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
    const Area frame = ViewLayout::below_caption(panel);
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
  /// Back to the whole image.
  void reset() { *this = {}; }
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
