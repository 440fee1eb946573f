#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <vector>

namespace saccade {

/// Histogram of durations in fixed memory: bins are 1/16 of an octave wide, so a quantile is at most 6.3 % too long. add()
/// is a few instructions.
class TimeFigures {
 public:
  void add(std::int64_t us) {
    us = std::clamp<std::int64_t>(us, 0, longest_us);
    ++bins_[bin_of(us)];
    ++count_;
    max_us_ = std::max(max_us_, us);
  }
  void clear() { *this = {}; }

  [[nodiscard]] std::int64_t count() const { return count_; }
  [[nodiscard]] std::int64_t max_us() const { return max_us_; }
  /// The least duration that `share` of all do not exceed; 0 without any.
  [[nodiscard]] std::int64_t quantile_us(double share) const {
    const double wanted = share * static_cast<double>(count_);
    std::int64_t seen = 0;
    for (std::size_t bin = 0; bin < bins_.size(); ++bin) {
      seen += bins_[bin];
      if (seen > 0 && static_cast<double>(seen) >= wanted) return std::min(end_of(bin), max_us_);
    }
    return max_us_;
  }

 private:
  static constexpr std::int64_t longest_us = (std::int64_t{1} << 36) - 1;  // 19 hours
  static constexpr int steps_log2 = 4;

  // Below 2^5 each value has a bin; above, an octave has 16.
  static std::size_t bin_of(std::int64_t us) {
    const auto value = static_cast<std::uint64_t>(us);
    const int octave = std::max(0, static_cast<int>(std::bit_width(value)) - (steps_log2 + 1));
    return static_cast<std::size_t>((octave << steps_log2) + static_cast<int>(value >> octave));
  }
  static std::int64_t end_of(std::size_t bin) {
    const std::size_t steps = std::size_t{1} << steps_log2;
    const std::size_t octave = bin < 2 * steps ? 0 : bin / steps - 1;
    return static_cast<std::int64_t>(((bin - octave * steps + 1) << octave) - 1);
  }

  std::array<std::int64_t, 33 * 16> bins_{};
  std::int64_t count_ = 0;
  std::int64_t max_us_ = 0;
};

/// Histogram of durations in bins of 1 us, up to 50 ms; longer ones are counted in one bin.
class MicrosecondHistogram {
 public:
  static constexpr std::int64_t longest_us = 50'000;

  void add(std::int64_t us) {
    ++(us > longest_us ? over_ : bins_[static_cast<std::size_t>(std::max<std::int64_t>(us, 0))]);
  }
  /// Number of durations of `us`.
  [[nodiscard]] std::int64_t count(std::int64_t us) const { return bins_[static_cast<std::size_t>(us)]; }
  [[nodiscard]] std::int64_t over() const { return over_; }

 private:
  std::vector<std::int64_t> bins_ = std::vector<std::int64_t>(longest_us + 1);
  std::int64_t over_ = 0;
};

}  // namespace saccade
