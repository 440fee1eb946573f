#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace saccade {

/// Why a simulated event camera made an event.
enum class EventCause : std::uint8_t { signal, leak, shot, hot };
/// The causes' names in labels.csv and metrics.json, in the order of EventCause.
inline constexpr std::array<std::string_view, 4> event_cause_names = {"signal", "leak", "shot", "hot"};

/// What an object in a simulated scene is. Where several are in a pixel, the smallest number counts.
enum class SceneObject : std::uint8_t { ball = 1, hand, arm, distractor, background };
/// The objects' names in labels.csv and metrics.json, in the order of SceneObject; the first one is that of number 1.
inline constexpr std::array<std::string_view, 5> scene_object_names = {"ball", "hand", "arm", "distractor",
                                                                       "background"};

/// The ground truth of an event, which no sensor reports: for recorders and scores, never for a detector.
struct EventLabel {
  /// `leak` where leakage was more than half of the way to the threshold.
  EventCause cause = EventCause::signal;
  /// Number of the object in the pixel as given with the images, a SceneObject in the simulator; 0 where none was given.
  std::uint8_t object = 0;

  friend bool operator==(const EventLabel&, const EventLabel&) = default;
};

}  // namespace saccade
