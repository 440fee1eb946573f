#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/camera.h"
#include "core/config.h"

namespace saccade {

/// What an event camera was shown while it was recorded. Luminances are in the unit of the emulator's `white`.
enum class StimulusKind {
  still,  ///< a uniform scene at rest
  panel,  ///< a patch of pixels whose luminance changes at known times
  board,  ///< an asymmetric grid of dark dots on white that moves across the image
  disc,   ///< a disc on annotated circles
};
constexpr auto words_of(StimulusKind) {
  return std::to_array<Word<StimulusKind>>({{StimulusKind::still, "still"},
                                            {StimulusKind::panel, "panel"},
                                            {StimulusKind::board, "board"},
                                            {StimulusKind::disc, "disc"}});
}

/// Luminance of a panel from one of its points to the next.
enum class PanelChange {
  step,    ///< constant until the next point
  linear,  ///< a straight line in time
};
constexpr auto words_of(PanelChange) {
  return std::to_array<Word<PanelChange>>({{PanelChange::step, "step"}, {PanelChange::linear, "linear"}});
}

/// A circle at an instant of the recording's clock.
struct TimedCircle {
  std::int64_t t_us = 0;
  Circle circle;
};

struct Stimulus {
  StimulusKind kind = StimulusKind::still;
  std::int64_t zero_us = 0;  ///< in the recording's clock: where the times of this stimulus count from
  std::optional<double> from_s, until_s;  ///< the part to use, after zero_us; none: all of it

  double luminance = 0.0;  ///< still

  /// Panel: its pixels; otherwise the pixels to use. x and y of the left top pixel, width and height; a width of 0:
  /// all pixels of the image.
  std::array<double, 4> region_px = {0.0, 0.0, 0.0, 0.0};
  static constexpr double max_panel_pixels = 50.0;
  PanelChange change = PanelChange::step;
  std::vector<std::array<double, 2>> points;  ///< panel: time, s, and luminance
  double period_s = 0.0;                      ///< panel: after that the points repeat; 0: they do not

  // Board: dot k of row i at (2 k + i % 2, i) spacings from the first dot, as `saccade calibrate` has it.
  std::int64_t columns = 4;
  std::int64_t rows = 7;
  double spacing_px = 10.0;
  double dot_diameter_px = 8.0;
  std::vector<std::array<double, 3>>
      path;  ///< time, s, and x, y of the first dot's centre, px; straight in between

  std::string circles_file;          ///< disc: a table t_us,x_px,y_px,r_px in the recording's clock
  std::vector<TimedCircle> circles;  ///< its rows
  double dark = 10.0;                ///< luminance of dots or disc
  double light = 200.0;              ///< luminance around them
  double blur_px = 0.5;              ///< width of an edge beyond that of a pixel
  bool known_contrast = true;        ///< disc: whether dark and light are measured

  /// Whether it shows changes of light.
  [[nodiscard]] bool moves() const { return kind != StimulusKind::still; }
};

/// Keys: kind, zero_us, from_s, until_s and those of the kind.
void describe(FieldVisitor& v, Stimulus& stimulus);

/// A stimulus for each recording, by the recording's name without its extension.
using NamedStimuli = std::vector<std::pair<std::string, Stimulus>>;

/// A stimulus file. Keys: white, dark_current, stimuli.NAME.
struct StimulusFile {
  double white = 255.0;        ///< luminance of white, the emulator's key
  double dark_current = 10.0;  ///< the emulator's key
  NamedStimuli stimuli;
};
void describe(FieldVisitor& v, StimulusFile& file);

/// The interval of the recording's clock that the stimulus describes; for a still scene that of the recording.
struct StimulusInterval {
  std::int64_t begin_us = 0;
  std::int64_t end_us = 0;
};
[[nodiscard]] StimulusInterval interval_of(const Stimulus& stimulus, std::int64_t first_us,
                                           std::int64_t last_us);

/// Times of images, us after the start of the interval, that show the stimulus well enough for the emulator: nothing moves
/// by more than 0.2 px from one to the next, and a panel's steps take 1 us.
[[nodiscard]] std::vector<std::int64_t> image_times_us(const Stimulus& stimulus, StimulusInterval interval);

/// The luminance of pixel (x, y) at an instant of the recording's clock. `contrast_scale`: exponent of dark / light.
class ShownStimulus {
 public:
  ShownStimulus(const Stimulus& stimulus, double contrast_scale = 1.0);
  void move_to(std::int64_t t_us);
  [[nodiscard]] float luminance(double x, double y) const;

 private:
  [[nodiscard]] double dark_share(double dx_px, double dy_px, double radius_px) const;

  const Stimulus& stimulus_;
  double dark_;
  double level_ = 0.0;          // of still and panel
  std::array<double, 2> at_{};  // the board's first dot
  Circle circle_;
};

/// A step of a panel: when it begins, after the start of a period, and its luminances before and after.
struct PanelStep {
  double t_s = 0.0;
  double until_s = 0.0;  ///< the next one
  double before = 0.0;
  double after = 0.0;
};
[[nodiscard]] std::vector<PanelStep> steps_of(const Stimulus& panel);

}  // namespace saccade
