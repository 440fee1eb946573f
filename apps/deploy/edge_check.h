#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/event.h"
#include "robot/robot.h"

namespace saccade {

/// What the events of one camera at rest show of its polarity while something brighter than all behind it moves into the
/// image: at each pixel the polarity of the first event of an edge since the start. An edge makes events of one polarity at
/// three or more of the eight neighbours within 30 ms; noise seldom does.
class EdgePolarity {
 public:
  explicit EdgePolarity(ImageSize size);
  /// Takes an event inside the image, in the order of time.
  void add(const Event& event);

  /// Pixels whose first event of an edge was ON, or OFF.
  [[nodiscard]] std::int64_t on() const { return on_; }
  [[nodiscard]] std::int64_t off() const { return off_; }
  /// Whether there was any event.
  [[nodiscard]] bool has_events() const { return has_events_; }

 private:
  [[nodiscard]] bool is_of_an_edge(const Event& event) const;

  ImageSize size_;
  std::vector<std::int64_t> newest_us_;  ///< of each pixel, OFF in the first half, ON in the second
  std::vector<std::uint8_t> is_decided_;
  std::int64_t on_ = 0, off_ = 0;
  bool has_events_ = false;
};

/// Whether ON means brighter for each camera of the robot that sends events, one check each: watches it at rest for a second,
/// asks on the standard error output that something bright be moved into the image, and waits until its edge has crossed a
/// fifth of the pixels, or for `longest_s`. Fails if the image was not at rest, if the edge crossed less than a twentieth of
/// the pixels, or if less than four fifths of them agree. `remedy` follows the finding that ON means darker. `robot` has a
/// clock that waits by itself.
[[nodiscard]] std::vector<StartUpCheck> edge_checks(Robot& robot, double longest_s,
                                                    const std::string& remedy);

}  // namespace saccade
