#pragma once

#include <cstdint>

namespace saccade {

/// A request of the user, made with a key or a widget.
struct Action {
  enum class Type {
    close,
    ask_close,  ///< shows the question whether to close the window, or hides it
    answer,     ///< closes the window if the question is shown
    toggle_playing,
    seek,             ///< value: t_us
    seek_start,       ///< to the start
    step,             ///< value: us; negative: back
    set_speed,        ///< value: exponent of 2, see SpeedRange
    change_speed,     ///< value: +1 or -1, added to the exponent
    scale_threshold,  ///< value: +1 or -1, up or down by a tenth
    select_detector,  ///< value: index in ViewSettings::detectors
    apply_settings,   ///< those of ViewState
    toggle_image,
    toggle_circles,
    take_screenshot,
    toggle_video,
    save_settings,  ///< as a file
    toggle_help,
  };
  Type type = Type::close;
  std::int64_t value = 0;

  friend bool operator==(const Action&, const Action&) = default;
};

/// Playback speed is 2 to the power of an exponent; above `fastest` it is unlimited.
struct SpeedRange {
  static constexpr int slowest = -5;
  static constexpr int fastest = 4;
  static constexpr int unlimited = fastest + 1;
};

}  // namespace saccade
