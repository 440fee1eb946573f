#pragma once

#include <cmath>
#include <cstdint>
#include <deque>
#include <numbers>
#include <optional>
#include <vector>

#include "core/event.h"
#include "core/hough/hough_transform.h"

namespace saccade {

/// A slow reference implementation of the transform of the paper, sections II-B and II-C: for one event, it tests every
/// radius and every pixel of the image by geometry for being a centre that the event votes for. The
/// oracle of HoughTransform and HoughDetector.
class ReferenceHough {
 public:
  /// Full where `arc_rad` is absent, otherwise directed.
  ReferenceHough(ImageSize size, int r_min, int r_max, std::size_t window, std::optional<double> arc_rad)
      : size_(size), r_min_(r_min), r_max_(r_max), window_(window), arc_rad_(arc_rad) {
    for (int r = r_min; r <= r_max; ++r) {
      int pixels = 0;
      for (int dy = -r - 1; dy <= r + 1; ++dy) {
        for (int dx = -r - 1; dx <= r + 1; ++dx) pixels += on_ring(dx, dy, r) ? 1 : 0;
      }
      ring_pixels_.push_back(pixels);
    }
    votes_ = no_votes();
  }

  /// An event enters the window and, when that is full, the oldest leaves it. `direction_rad` is that of its
  /// flow; without it the event has no votes (directed only).
  void push(int x, int y, std::optional<double> direction_rad) {
    events_.push_back({x, y, direction_rad});
    vote(votes_, events_.back(), 1);
    if (events_.size() <= window_) return;
    vote(votes_, events_.front(), -1);
    events_.pop_front();
  }

  /// Votes of [r][y][x] as push() kept them, and counted afresh from the events in the window.
  [[nodiscard]] const std::vector<int>& votes() const { return votes_; }
  [[nodiscard]] std::vector<int> recount() const {
    std::vector<int> votes = no_votes();
    for (const Entry& entry : events_) vote(votes, entry, 1);
    return votes;
  }
  [[nodiscard]] int ring_pixels(int r) const { return ring_pixels_[static_cast<std::size_t>(r - r_min_)]; }

  struct Peak {
    int x = 0, y = 0, r = 0, votes = 0;
    friend bool operator==(const Peak&, const Peak&) = default;
  };
  /// The largest votes / ring pixels; the first in the order of r, y, x of those that are equal.
  [[nodiscard]] Peak peak() const {
    Peak best{0, 0, r_min_, 0};
    std::size_t i = 0;
    for (int r = r_min_; r <= r_max_; ++r) {
      for (int y = 0; y < size_.height; ++y) {
        for (int x = 0; x < size_.width; ++x, ++i) {
          if (votes_[i] * ring_pixels(best.r) > best.votes * ring_pixels(r)) best = {x, y, r, votes_[i]};
        }
      }
    }
    return best;
  }

 private:
  struct Entry {
    int x, y;
    std::optional<double> direction_rad;
  };

  [[nodiscard]] static bool on_ring(int dx, int dy, int r) { return std::abs(std::hypot(dx, dy) - r) <= 0.5; }

  [[nodiscard]] bool votes_for(const Entry& e, int cx, int cy, int r) const {
    if (!on_ring(cx - e.x, cy - e.y, r)) return false;
    if (!arc_rad_) return true;
    if (!e.direction_rad) return false;
    // The direction and its opposite are one: angles modulo a half turn. A pixel on an arc's edge counts.
    const double angle = std::atan2(cy - e.y, cx - e.x);
    return std::abs(std::remainder(angle - *e.direction_rad, std::numbers::pi)) <= *arc_rad_ + 1e-9;
  }

  void vote(std::vector<int>& votes, const Entry& e, int sign) const {
    std::size_t i = 0;
    for (int r = r_min_; r <= r_max_; ++r) {
      for (int y = 0; y < size_.height; ++y) {
        for (int x = 0; x < size_.width; ++x, ++i) {
          if (votes_for(e, x, y, r)) votes[i] += sign;
        }
      }
    }
  }

  [[nodiscard]] std::vector<int> no_votes() const {
    return std::vector<int>(ring_pixels_.size() * static_cast<std::size_t>(size_.pixels()), 0);
  }

  ImageSize size_;
  int r_min_, r_max_;
  std::size_t window_;
  std::optional<double> arc_rad_;
  std::vector<int> ring_pixels_;
  std::deque<Entry> events_;
  std::vector<int> votes_;
};

/// What the fast transform has, in the terms of the reference.
inline double radians_of(int direction) {
  return direction * std::numbers::pi / HoughTransform::direction_count;
}

inline std::vector<int> all_votes(const HoughTransform& transform) {
  std::vector<int> votes;
  for (int r = transform.r_min(); r <= transform.r_max(); ++r) {
    for (int y = 0; y < transform.size().height; ++y) {
      for (int x = 0; x < transform.size().width; ++x) votes.push_back(transform.votes(x, y, r));
    }
  }
  return votes;
}

inline ReferenceHough::Peak as_reference(const HoughTransform::Peak& p) { return {p.x, p.y, p.r, p.votes}; }

}  // namespace saccade
