#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/event.h"

namespace saccade {

/// A point of a moving edge: an event with the normal flow measured at it.
struct Edge {
  std::int64_t t_us = 0;
  std::int64_t end_us = 0;          ///< the end of its lifetime: its edge has moved on by then
  Eigen::Vector2d along{1.0, 0.0};  ///< unit vector of its motion
  double speed_px_s = 0.0;          ///< along it
  std::uint16_t x = 0, y = 0;
};

/// The newest edges of each region of the image. Regions are squares of `region_px` pixels. Each holds its newest
/// `capacity` edges until the end of their lifetimes, so a region is independent of the event rate elsewhere. (A
/// first-in, first-out window over the whole image loses a ball that moves slowly in the image; paper, section V.)
/// Does not allocate after construction.
class EdgeMap {
 public:
  static constexpr int region_px = 8;

  EdgeMap(ImageSize size, int capacity)
      : columns_((size.width + region_px - 1) / region_px),
        rows_((size.height + region_px - 1) / region_px),
        capacity_(static_cast<std::size_t>(capacity)),
        edges_(static_cast<std::size_t>(columns_ * rows_) * capacity_),
        counts_(static_cast<std::size_t>(columns_ * rows_), 0) {}

  /// The edge lies inside the image.
  void add(const Edge& edge) {
    const std::size_t region = index(edge.x / region_px, edge.y / region_px);
    edges_[region * capacity_ + counts_[region]++ % capacity_] = edge;
    last_end_us_ = std::max(last_end_us_, edge.end_us);
  }
  /// The end of the last lifetime of all edges added so far, us.
  [[nodiscard]] std::int64_t last_end_us() const { return last_end_us_; }
  /// The largest number of edges that the map can hold.
  [[nodiscard]] std::size_t capacity() const { return edges_.size(); }

  /// Calls f(const Edge&) for every edge whose lifetime has not ended at now_us, region by region in rows.
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
      if (edge.end_us >= now_us) f(edge);
    }
  }

  int columns_, rows_;
  std::size_t capacity_;
  std::vector<Edge> edges_;  // regions x capacity
  std::vector<std::size_t> counts_;
  std::int64_t last_end_us_ = std::numeric_limits<std::int64_t>::min();
};

}  // namespace saccade
