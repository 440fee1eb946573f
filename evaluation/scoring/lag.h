#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/camera.h"
#include "evaluation/scoring/statistics.h"

namespace saccade {

/// How late a detector's circles are, from a stream of true and detected circles in bounded memory.
///
/// The lag is the shift s in [-50, 200] ms (0.1 ms steps) that minimises the median distance between the observation
/// at t and the true centre, linearly interpolated, at t - s; positive = late; of equal shifts the one nearest 0.
/// An observation counts where the true centre is known for every such s, that is without a gap of more than 20 ms.
///
/// Up to `max_exact` instants (40 bytes each) all of them count. When there are more, every second block of 4096
/// instants is dropped, then every second one of those left, and so on: the lag is then that of the blocks kept, which
/// stay evenly spaced over the whole run.
class LagCounter {
 public:
  explicit LagCounter(std::size_t max_exact = max_exact_values) : max_exact_(max_exact) {}

  /// One instant; time goes forward. `truth`: none where there is no true circle. `observed`: none where no
  /// observation counts.
  void add(std::int64_t t_us, const std::optional<Circle>& truth, const std::optional<Circle>& observed);
  [[nodiscard]] bool exact() const { return stride_ == 1; }
  /// None where no observation counts.
  [[nodiscard]] std::optional<double> lag_ms() const;

 private:
  friend class TruePath;
  struct Instant {
    std::int64_t t_us;
    double x_px, y_px;                    // of the true centre; NaN where there is none
    double observed_x_px, observed_y_px;  // NaN where there is none
  };
  struct Block {
    std::int64_t number;
    std::vector<Instant> instants;
  };

  std::size_t max_exact_;
  std::int64_t count_ = 0;
  std::int64_t stride_ = 1;  // blocks whose number is a multiple of it are kept
  std::vector<Block> blocks_;
};

}  // namespace saccade
