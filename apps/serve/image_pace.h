#pragma once

#include <cstdint>
#include <string>

namespace saccade::inline v0_1 {

/// The shortest interval between the images of a served robot. It grows while serve is behind the wall clock, so that an
/// image waits until serve has caught up, or until the previous one is longest_us old: then simulated time keeps pace, and
/// packets keep coming, with fewer images.
class ImagePace {
 public:
  static constexpr std::int64_t longest_us = 10'000;
  /// Delays up to this are those of any waiting thread.
  static constexpr std::int64_t usual_late_us = 2'000;

  /// `usual_us`: the interval while serve keeps pace; a longer one than longest_us stays.
  explicit ImagePace(std::int64_t usual_us) : usual_us_(usual_us) {}

  /// Once per tick: by how much it begins late. Returns the shortest interval between images from now on.
  std::int64_t next(std::int64_t late_us);

  /// Share of the ticks with a longer interval than the usual one.
  [[nodiscard]] double slowed_share() const;
  /// Mean interval in these ticks, and the longest one; the usual one without any. ms.
  [[nodiscard]] double slowed_interval_ms() const;
  [[nodiscard]] double longest_interval_ms() const;
  [[nodiscard]] double usual_interval_ms() const { return 1e-3 * static_cast<double>(usual_us_); }
  /// "images 6.2 ms apart instead of 1 in 12 % of the time", or "images 1 ms apart". At least, as the motion permits.
  [[nodiscard]] std::string summary() const;

 private:
  std::int64_t usual_us_;
  std::int64_t ticks_ = 0, slowed_ = 0;
  std::int64_t slowed_sum_us_ = 0, slowed_most_us_ = 0;
};

}  // namespace saccade::inline v0_1
