#pragma once

#include <cstdint>
#include <string>

namespace saccade {

/// The shortest interval between the images of a served robot. While serve is behind the wall clock, an image waits until serve
/// has caught up, or until the previous one is longest_us old: simulated time keeps pace, and packets keep coming, with fewer
/// images.
class ImagePace {
 public:
  static constexpr std::int64_t longest_us = 10'000;
  /// Delays up to this are those of any waiting thread.
  static constexpr std::int64_t usual_late_us = 2'000;

  /// `usual_us`: the interval while serve keeps pace; a longer one than longest_us stays.
  explicit ImagePace(std::int64_t usual_us) : usual_us_(usual_us) {}

  /// Once per tick: by how much it begins late, and the time of the newest image. Returns the shortest interval between images
  /// from now on.
  std::int64_t next(std::int64_t late_us, std::int64_t image_us);

  /// Share of the ticks in which images were held back.
  [[nodiscard]] double held_share() const;
  /// Mean and largest time between two images of which the second was held back; the usual interval without any. ms.
  [[nodiscard]] double held_interval_ms() const;
  [[nodiscard]] double longest_interval_ms() const;
  [[nodiscard]] double usual_interval_ms() const { return 1e-3 * static_cast<double>(usual_us_); }
  /// "images at least 1 ms apart; held back in 12.0 % of the time, then 6.2 ms apart", or its first part.
  [[nodiscard]] std::string summary() const;

 private:
  std::int64_t usual_us_;
  std::int64_t ticks_ = 0, held_ticks_ = 0;
  std::int64_t image_us_ = 0;
  bool held_ = false;  // the next image
  std::int64_t held_images_ = 0, held_sum_us_ = 0, held_most_us_ = 0;
};

}  // namespace saccade
