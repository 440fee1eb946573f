#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/config.h"
#include "core/event.h"

namespace saccade {

/// The pixel of a dynamic vision sensor: it holds a reference log luminance and emits an event when log
/// luminance has moved by its ON or OFF threshold from it (Lichtsteiner, Posch, Delbruck, JSSC 43(2), 2008).
struct EmulatorConfig {
  std::string preset = "dvs128";        ///< where the values below start from
  double contrast_threshold_on = 0.2;   ///< rise of ln luminance per ON event
  double contrast_threshold_off = 0.2;  ///< fall of ln luminance per OFF event
  double threshold_mismatch = 0.021;    ///< relative standard deviation over pixels, fixed per pixel
  std::int64_t refractory_us = 500;     ///< after an event the pixel is held in reset this long
  double dark_current = 10.0;           ///< L = ln(luminance + dark_current); unit of the luminance
};

/// Names that `preset` may take: ideal (no mismatch, no refractory period), dvs128.
[[nodiscard]] const std::vector<std::string>& emulator_presets();
/// The configuration of a preset. Throws InputError for an unknown name.
[[nodiscard]] EmulatorConfig emulator_preset(const std::string& name);
/// Keys: preset, contrast_threshold_on, contrast_threshold_off, threshold_mismatch, refractory_us,
/// dark_current.
void describe(FieldVisitor& v, EmulatorConfig& config);

/// Turns a sequence of luminance images into events, each stamped with its own crossing time.
///
/// Between two images the log luminance of a pixel is a straight line in time; a pixel emits wherever the
/// line meets reference +- threshold, and the reference moves to that level. An event is stamped with the
/// first whole microsecond at or after the crossing. A second crossing of one pixel within a microsecond is
/// stamped one microsecond later, if need be after the next image (unless the light has turned back by
/// then). With a refractory period the pixel is held in reset from its event for refractory_us, and the
/// reference is the log luminance at the end of it. Thresholds differ from pixel to pixel by a fixed, seeded
/// factor, not below 5 % of their nominal value.
///
/// The number of events and their times do not depend on how finely a given luminance course is sampled.
class EventEmulator {
 public:
  /// Throws InputError for a configuration out of range.
  EventEmulator(const EmulatorConfig& config, ImageSize size, std::uint64_t seed);

  /// Takes the image at t_us and appends the events in (previous t_us, t_us], sorted by time and, within a
  /// microsecond, by row and column. The first image sets the references and makes no event.
  /// `luminance`: size.height x size.width, row by row, linear light, >= 0.
  /// Throws InputError when time does not advance or a value is negative or not finite (nothing is changed).
  void process_image(std::span<const float> luminance, std::int64_t t_us, std::vector<Event>& events);

  [[nodiscard]] std::int64_t event_count() const { return event_count_; }

  /// The references and the newest log luminance, row by row, for tests that rebuild the image from events.
  [[nodiscard]] std::span<const double> reference_log() const { return reference_; }
  [[nodiscard]] std::span<const double> newest_log() const { return log_now_; }

 private:
  void emit_pixel(std::size_t pixel, std::int64_t t0, std::int64_t t1);
  void sort_into(std::vector<Event>& events, std::int64_t t0, std::int64_t t1);

  EmulatorConfig config_;
  ImageSize size_;
  bool started_ = false;
  std::int64_t t_us_ = 0;
  std::int64_t event_count_ = 0;
  std::vector<double> log_before_, log_now_, reference_;
  std::vector<double> threshold_on_, threshold_off_;
  std::vector<std::int64_t> last_event_us_;   // stamp of the pixel's newest event
  std::vector<std::int64_t> reset_until_us_;  // end of the pixel's refractory period
  std::vector<Event> unsorted_;
  std::vector<std::uint32_t> first_at_;  // counting sort by time
};

}  // namespace saccade
