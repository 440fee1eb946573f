#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "core/event.h"

namespace saccade {

/// Statistics of a stream of events. Differences of times that int64 cannot hold are limited to its range.
struct EventStatistics {
  std::int64_t count = 0;
  std::int64_t on = 0;
  std::int64_t first_us = 0;   ///< the time of the first event in the stream
  std::int64_t oldest_us = 0;  ///< the smallest of all times
  std::int64_t newest_us = 0;
  ImageSize reach{0, 0};           ///< the smallest image that holds all events
  std::int64_t outside_image = 0;  ///< 0 where the image size is unknown
  std::int64_t back_in_time = 0;   ///< events older than the newest one before them
  std::int64_t longest_step_back_us = 0;
  std::int64_t longest_gap_us = 0;  ///< the longest time without an event, and its beginning
  std::int64_t longest_gap_at_us = 0;
  std::int64_t gaps = 0;         ///< longer than EventCounter's gap_us
  std::int64_t most_in_1ms = 0;  ///< events in the fullest bin of that length; bins begin at the first event,
  std::int64_t most_in_100ms = 0;  ///< and a late event counts in the newest bin

  [[nodiscard]] double duration_s() const;
  /// Events per second; none where the duration is 0.
  [[nodiscard]] std::optional<double> mean_rate_hz() const;
};

/// Computes the statistics of all cameras together and of each one, in fixed memory.
class EventCounter {
 public:
  /// `image_size`: none where it is unknown. A gap is counted when it is longer than `gap_us`.
  EventCounter(std::optional<ImageSize> image_size, std::int64_t gap_us)
      : image_size_(image_size), gap_us_(gap_us) {}

  void add(std::span<const Event> events);

  [[nodiscard]] const EventStatistics& all() const { return (both_ ? all_ : cameras_[only_]).statistics; }
  /// 0 left, 1 right.
  [[nodiscard]] const EventStatistics& camera(int camera) const {
    return cameras_[static_cast<std::size_t>(camera)].statistics;
  }

 private:
  struct Bin {
    std::int64_t begin_us = 0;
    std::int64_t count = 0;
  };
  struct Stream {
    EventStatistics statistics;
    Bin short_bin;
    Bin long_bin;
  };

  [[nodiscard]] bool add_in_order(Stream& stream, std::span<const Event> events) const;
  template <class Takes>
  void add(Stream& stream, std::span<const Event> events, const Takes& takes) const;

  std::optional<ImageSize> image_size_;
  std::int64_t gap_us_;
  std::array<Stream, 2> cameras_;
  std::size_t only_ = 0;  ///< the camera of all events so far
  bool both_ = false;     ///< events of both came: then all_ is counted on its own
  Stream all_;
};

}  // namespace saccade
