#include "evaluation/scoring/lag.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <tuple>

namespace saccade {
namespace {

constexpr std::int64_t block_size = 4096;
constexpr std::int64_t lag_step_us = 100;
constexpr int min_lag_steps = -500;
constexpr int max_lag_steps = 2000;
constexpr std::int64_t longest_gap_us = 20'000;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

}  // namespace

/// The true centre as a function of time, piecewise linear, with gaps where there is no circle for long.
class TruePath {
 public:
  using Instant = LagCounter::Instant;

  explicit TruePath(const std::vector<LagCounter::Block>& blocks) {
    std::size_t start = 0;
    std::int64_t expected = 0;
    for (const LagCounter::Block& block : blocks) {
      if (block.number != expected) start = nodes_.size();
      expected = block.number + 1;
      for (const Instant& instant : block.instants) start = append(instant, start);
    }
  }

  [[nodiscard]] double max_speed_px_us() const { return max_speed_px_us_; }

  /// True when the centre is known at every instant of the closed interval.
  [[nodiscard]] bool covers(std::int64_t from_us, std::int64_t to_us) const {
    const auto after = std::lower_bound(nodes_.begin(), nodes_.end(), to_us,
                                        [](const Node& node, std::int64_t t_us) { return node.t_us < t_us; });
    return after != nodes_.end() && nodes_[after->stretch_start].t_us <= from_us;
  }

  /// Distance of the observation from the true centre at `t_us`. `hint` carries the place in the table from
  /// call to call; t_us must not go back and must be covered.
  [[nodiscard]] double distance_px(const Instant& observed, std::int64_t t_us, std::size_t& hint) const {
    while (nodes_[hint].t_us < t_us) ++hint;
    const Node& b = nodes_[hint];
    if (b.t_us == t_us) return std::hypot(observed.observed_x_px - b.x_px, observed.observed_y_px - b.y_px);
    const Node& a = nodes_[hint - 1];
    const double share = static_cast<double>(t_us - a.t_us) / static_cast<double>(b.t_us - a.t_us);
    return std::hypot(observed.observed_x_px - (a.x_px + share * (b.x_px - a.x_px)),
                      observed.observed_y_px - (a.y_px + share * (b.y_px - a.y_px)));
  }

 private:
  struct Node {
    std::int64_t t_us;
    std::size_t stretch_start;  ///< index of the first node since the last gap
    double x_px;
    double y_px;
  };

  /// Returns the start of the stretch that the next instant belongs to.
  std::size_t append(const Instant& instant, std::size_t start) {
    if (std::isnan(instant.x_px)) return nodes_.size();
    if (nodes_.size() > start && instant.t_us - nodes_.back().t_us > longest_gap_us) start = nodes_.size();
    if (nodes_.size() > start) {
      const Node& last = nodes_.back();
      const double distance = std::hypot(instant.x_px - last.x_px, instant.y_px - last.y_px);
      const auto time_us = static_cast<double>(std::max<std::int64_t>(1, instant.t_us - last.t_us));
      max_speed_px_us_ = std::max(max_speed_px_us_, distance / time_us);
    }
    nodes_.push_back({instant.t_us, start, instant.x_px, instant.y_px});
    return start;
  }

  std::vector<Node> nodes_;
  double max_speed_px_us_ = 0.0;
};

void LagCounter::add(std::int64_t t_us, const std::optional<Circle>& truth,
                     const std::optional<Circle>& observed) {
  const std::int64_t block = count_++ / block_size;
  if (block % stride_ != 0) return;
  if (blocks_.empty() || blocks_.back().number != block) {
    const std::size_t kept = blocks_.size() * static_cast<std::size_t>(block_size);
    if (kept >= max_exact_ && blocks_.size() > 1) {
      stride_ *= 2;
      std::erase_if(blocks_, [this](const Block& b) { return b.number % stride_ != 0; });
      if (block % stride_ != 0) return;
    }
    blocks_.push_back({block, {}});
  }
  const Circle none{nan, nan, nan};
  const Circle& t = truth ? *truth : none;
  const Circle& o = observed ? *observed : none;
  blocks_.back().instants.push_back({t_us, t.x_px, t.y_px, o.x_px, o.y_px});
}

/// The exact minimum over all shifts without trying most of them: no distance, hence no median, changes
/// faster with the shift than the truth moves.
std::optional<double> LagCounter::lag_ms() const {
  const TruePath path(blocks_);
  std::vector<const Instant*> observed;
  for (const Block& block : blocks_) {
    for (const Instant& i : block.instants) {
      if (!std::isnan(i.observed_x_px) &&
          path.covers(i.t_us - max_lag_steps * lag_step_us, i.t_us - min_lag_steps * lag_step_us)) {
        observed.push_back(&i);
      }
    }
  }
  if (observed.empty()) return std::nullopt;

  std::vector<double> distances_px(observed.size());
  const auto median_px = [&](int steps) {
    std::size_t hint = 0;
    for (std::size_t i = 0; i < observed.size(); ++i) {
      distances_px[i] = path.distance_px(*observed[i], observed[i]->t_us - steps * lag_step_us, hint);
    }
    return *quantile(distances_px, 0.5);
  };

  struct Stretch {
    double least_px;  ///< no shift in [first, last] has a smaller median
    int first;
    int last;
    bool operator<(const Stretch& other) const { return least_px > other.least_px; }
  };
  std::priority_queue<Stretch> stretches;
  stretches.push({0.0, min_lag_steps, max_lag_steps});
  std::tuple<double, int, int> best{std::numeric_limits<double>::infinity(), 0, 0};  // median, |shift|, shift
  while (!stretches.empty() && stretches.top().least_px <= std::get<0>(best)) {
    const Stretch stretch = stretches.top();
    stretches.pop();
    const int middle = stretch.first + (stretch.last - stretch.first) / 2;
    const double value_px = median_px(middle);
    best = std::min(best, std::tuple{value_px, std::abs(middle), middle});
    const auto push = [&](int first, int last, int farthest) {
      if (first <= last) {
        const double reach_us = static_cast<double>(std::abs(farthest - middle) * lag_step_us);
        // A hair below the bound, for the rounding of the distances.
        stretches.push({value_px - path.max_speed_px_us() * reach_us * (1.0 + 1e-9) - 1e-9, first, last});
      }
    };
    push(stretch.first, middle - 1, stretch.first);
    push(middle + 1, stretch.last, stretch.last);
  }
  return static_cast<double>(std::get<2>(best)) * static_cast<double>(lag_step_us) / 1000.0;
}

}  // namespace saccade
