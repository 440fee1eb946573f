#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <vector>

#include "core/event.h"

namespace saccade {

/// An event with the normal flow measured at it: a piece of a moving edge.
struct Edge {
  std::int64_t t_us = 0;
  std::int64_t dies_us = 0;          ///< by then its edge will have moved on
  Eigen::Vector2d gradient_us_px{};  ///< (dt/dx, dt/dy): along the motion, 1 / speed long
  std::uint16_t x = 0, y = 0;
  std::int16_t direction = 0;  ///< of the gradient, see HoughTransform::direction_of()
};

/// The moving edges of an image, kept region by region: squares of `region_px` pixels that hold the newest
/// `capacity` edges each, for as long as these live. What is known of one place does not depend on how many
/// events the rest of the scene makes, which is what starves a first-in, first-out window while the gaze
/// follows (paper, section V). Nothing allocates after construction.
class EdgeMap {
 public:
  static constexpr int region_px = 8;

  EdgeMap(ImageSize size, int capacity)
      : columns_((size.width + region_px - 1) / region_px),
        rows_((size.height + region_px - 1) / region_px),
        capacity_(static_cast<std::size_t>(capacity)),
        edges_(static_cast<std::size_t>(columns_ * rows_) * capacity_),
        counts_(static_cast<std::size_t>(columns_ * rows_), 0) {}

  /// (x, y) inside the image.
  void add(const Edge& edge) {
    const std::size_t region = index(edge.x / region_px, edge.y / region_px);
    edges_[region * capacity_ + counts_[region]++ % capacity_] = edge;
    last_dies_us_ = std::max(last_dies_us_, edge.dies_us);
  }
  /// No edge lives after this instant.
  [[nodiscard]] std::int64_t last_dies_us() const { return last_dies_us_; }
  /// How many edges it can hold.
  [[nodiscard]] std::size_t room() const { return edges_.size(); }

  /// Calls f(const Edge&) for every edge that lives at now_us; by regions, row by row.
  template <class Function>
  void for_each(std::int64_t now_us, Function f) const {
    for (std::size_t region = 0; region < counts_.size(); ++region) visit(region, now_us, f);
  }
  /// The same for the regions that a square of half-width `reach_px` around a point touches.
  template <class Function>
  void for_each_near(double x_px, double y_px, double reach_px, std::int64_t now_us, Function f) const {
    const auto region = [](double px, int count) {
      return static_cast<int>(std::clamp(px / region_px, 0.0, count - 1.0));
    };
    const int x_end = region(x_px + reach_px, columns_);
    const int y_end = region(y_px + reach_px, rows_);
    for (int y = region(y_px - reach_px, rows_); y <= y_end; ++y) {
      for (int x = region(x_px - reach_px, columns_); x <= x_end; ++x) visit(index(x, y), now_us, f);
    }
  }

 private:
  [[nodiscard]] std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row * columns_ + column);
  }
  template <class Function>
  void visit(std::size_t region, std::int64_t now_us, Function& f) const {
    const std::size_t held = std::min(counts_[region], capacity_);
    for (std::size_t i = 0; i < held; ++i) {
      const Edge& edge = edges_[region * capacity_ + i];
      if (edge.dies_us >= now_us) f(edge);
    }
  }

  int columns_, rows_;
  std::size_t capacity_;
  std::vector<Edge> edges_;  // regions x capacity
  std::vector<std::size_t> counts_;
  std::int64_t last_dies_us_ = 0;
};

}  // namespace saccade
