#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "core/event.h"

namespace saccade {

/// What a stream of events is like, counted as it goes by, in fixed memory.
struct EventStatistics {
  std::int64_t count = 0;
  std::int64_t on = 0;
  std::int64_t first_us = 0;   ///< the time of the first event in the stream
  std::int64_t oldest_us = 0;  ///< the least of all times
  std::int64_t newest_us = 0;
  ImageSize reach{0, 0};           ///< the smallest image that holds all events
  std::int64_t outside_image = 0;  ///< 0 where the image size is not known
  std::int64_t back_in_time = 0;   ///< events older than the newest one before them
  std::int64_t longest_step_back_us = 0;
  std::int64_t longest_gap_us = 0;  ///< without an event, and where it began
  std::int64_t longest_gap_at_us = 0;
  std::int64_t gaps = 0;           ///< longer than the bound
  std::int64_t most_in_1ms = 0;    ///< in bins of that length from the first event on;
  std::int64_t most_in_100ms = 0;  ///< events that are late count in the newest bin

  [[nodiscard]] double duration_s() const { return 1e-6 * static_cast<double>(newest_us - oldest_us); }
  /// Events per second of the duration; none where that is 0.
  [[nodiscard]] std::optional<double> mean_rate_hz() const;
};

/// Counts for all cameras together and for each one.
class EventCounter {
 public:
  /// `image_size`: none where it is not known. A gap is counted when longer than `gap_us`.
  EventCounter(std::optional<ImageSize> image_size, std::int64_t gap_us)
      : image_size_(image_size), gap_us_(gap_us) {}

  void add(std::span<const Event> events);

  [[nodiscard]] const EventStatistics& all() const { return all_.statistics; }
  /// 0 left, 1 right.
  [[nodiscard]] const EventStatistics& camera(int camera) const {
    return cameras_[static_cast<std::size_t>(camera)].statistics;
  }

 private:
  struct Bin {
    std::int64_t end_us = 0;
    std::int64_t count = 0;
  };
  struct Stream {
    EventStatistics statistics;
    Bin short_bin;
    Bin long_bin;
  };

  void add(Stream& stream, const Event& event) const;

  std::optional<ImageSize> image_size_;
  std::int64_t gap_us_;
  Stream all_;
  std::array<Stream, 2> cameras_;
};

}  // namespace saccade
