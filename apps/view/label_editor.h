#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "apps/view/circle_labels.h"
#include "apps/view/images.h"

namespace saccade {

/// What the window of `saccade label` changes and shows, without the window: an instant of a recording, the circles at
/// instants, and what mouse and keys do to them. Coordinates are pixels of the recording's image.
class LabelEditor {
 public:
  /// `events`: at least one; they are sorted by time here.
  LabelEditor(std::vector<Event> events, ImageSize image, CircleLabels labels);

  [[nodiscard]] ImageSize image_size() const { return image_; }
  [[nodiscard]] std::int64_t first_us() const { return first_us_; }
  [[nodiscard]] std::int64_t last_us() const { return last_us_; }
  [[nodiscard]] const CircleLabels& labels() const { return labels_; }
  /// Whether the labels differ from those last marked as saved.
  [[nodiscard]] bool unsaved() const { return unsaved_; }
  void mark_saved() { unsaved_ = false; }

  [[nodiscard]] std::int64_t now_us() const { return now_us_; }
  /// Goes to an instant, the first or the last one where it lies outside. Ends a press, which places nothing more.
  void seek(std::int64_t t_us);
  void seek_previous_label();
  void seek_next_label();

  /// Playback from the instant on, until the last event; from the first event where the instant is the last one. Every
  /// seek, change and press pauses.
  void toggle_playing();
  [[nodiscard]] bool playing() const { return playing_; }
  /// Recorded time per wall-clock time: one of 1/20, 1/10, 1/5, 1/2, 1 and 2.
  [[nodiscard]] double speed() const { return speeds[speed_]; }
  /// The speed in words, "1/20".
  [[nodiscard]] std::string_view speed_text() const { return speed_texts[speed_]; }
  /// To the next speed up (1) or down (-1), if there is one.
  void change_speed(int by);
  /// Goes on by what is played in so much wall-clock time; nothing while it is paused.
  void advance(double wall_s);

  /// Events shown: those at most so far from the instant, before or after it.
  [[nodiscard]] std::int64_t reach_us() const { return reach_us_; }
  /// Shows events `factor` times as far away, within 100 us and 1 s.
  void scale_reach(double factor);
  [[nodiscard]] std::span<const Event> shown_events() const;
  /// Number of events in each of `parts` equal parts of the recording.
  [[nodiscard]] std::vector<float> event_counts(std::size_t parts) const;

  /// The circle of this instant, or the hint for it.
  [[nodiscard]] std::optional<Circle> circle() const { return labels_.hint(now_us_); }
  /// Whether the instant has a label: a circle, or the mark that the ball is hidden.
  [[nodiscard]] bool labelled() const { return labels_.at(now_us_) != nullptr; }
  [[nodiscard]] bool hidden() const;

  /// A press without a drag places the circle there, wherever the circle or the hint is. A drag from the outline changes the
  /// radius, one from inside moves the centre by as much as the mouse, one from elsewhere begins with the circle at the press.
  /// drag() follows until release(), which ends the press.
  void press(double x_px, double y_px);
  void drag(double x_px, double y_px);
  void release();
  /// Changes the radius of the instant's circle, or of the hint, which becomes a label.
  void grow(double px);
  /// Moves the centre likewise.
  void move(double x_px, double y_px);
  /// The hint becomes a label.
  void accept_hint();
  /// Fits the instant's circle, or the hint, to the edges in the shown events (snapped_circle()); it is a label then. False,
  /// and nothing changes, where there is no circle or too few edges are near.
  bool snap();
  /// The ball is hidden at this instant; a second call removes the mark.
  void toggle_hidden();
  void remove();
  /// Takes back the last change, up to 1000 of them; a drag is one. Goes to the instant of that change.
  void undo();

 private:
  static constexpr std::array speeds = {0.05, 0.1, 0.2, 0.5, 1.0, 2.0};
  static constexpr std::array<std::string_view, speeds.size()> speed_texts = {"1/20", "1/10", "1/5",
                                                                              "1/2",  "1",    "2"};

  enum class Hold { centre, radius };
  struct Press {
    double x_px = 0.0, y_px = 0.0;
    Hold hold = Hold::centre;  ///< what a drag changes
    Circle circle;             ///< at the press: the instant's own or the hint
    bool has_placed = false;   ///< a circle; release() does otherwise
  };
  struct Change {
    std::int64_t t_us = 0;
    std::optional<TruthRow> before;  ///< none: there was no row
  };

  /// Remembers the state of this instant before a change.
  void begin_change();
  void change_by_press(const Circle& circle);
  void place(Circle circle);

  std::vector<Event> events_;
  ImageSize image_;
  CircleLabels labels_;
  std::int64_t first_us_ = 0;
  std::int64_t last_us_ = 0;
  std::int64_t now_us_ = 0;
  std::int64_t reach_us_ = 5'000;
  bool playing_ = false;
  std::size_t speed_ = 1;
  bool unsaved_ = false;
  std::optional<Press> press_;
  double last_r_px_ = 0.0;  ///< of the circle placed last
  std::vector<Change> changes_;
};

/// Paints the events around an instant, each pixel in the polarity of its event nearest in time, paler with the distance.
void paint_instant(const LabelEditor& editor, RgbImage& rgb);

}  // namespace saccade
