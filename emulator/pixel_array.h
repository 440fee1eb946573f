#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/random.h"
#include "emulator/emulator_config.h"
#include "emulator/level_trajectory.h"
#include "threads/large_vector.h"

namespace saccade {

/// An event of a pixel on its way to the readout.
struct PixelEvent {
  std::int64_t t_us = 0;
  std::uint32_t pixel = 0;  ///< of the whole image, row by row
  bool on = false;
  std::uint8_t cause = 0;   ///< EventCause
  std::uint8_t object = 0;  ///< EventLabel::object
};

/// A range of the sensor's pixels from photoreceptor to comparators, with the parameters of EmulatorConfig but without
/// latency and readout. A pixel's events depend on its number in the image, not on its neighbours.
class PixelArray {
 public:
  /// Pixels [first, first + count) of the image. The config is checked already.
  PixelArray(const EmulatorConfig& config, std::size_t first, std::size_t count, std::uint64_t seed);

  /// Takes these pixels' luminance at t_us (all finite and not negative; time advances), and their objects where
  /// known; replaces `events` by those in (previous t_us, t_us], ordered by pixel, and by time for each.
  void process(std::span<const float> luminance, std::span<const std::uint8_t> objects, std::int64_t t_us,
               std::vector<PixelEvent>& events);

  [[nodiscard]] double reference_log(std::size_t index) const;
  [[nodiscard]] double output_log(std::size_t index) const;

 private:
  static constexpr std::size_t block_size = 512;

  /// State of a pixel that only active pixels need. Levels are "with leakage": the leakage of the reference since the first
  /// image is added to the photoreceptor's output instead, so that references are constant.
  struct alignas(64) Pixel {      // a cache line
    double reference;             // level
    double noise_s;               // time of the next noise candidate, since the first image
    std::int64_t last_event_us;   // its stamp
    std::int64_t reset_until_us;  // end of the newest reset
    float threshold_on, threshold_off;
    float leak_per_us;          // level
    float noise_rate_hz;        // candidates: shot noise in the dark and hot pixel together
    std::uint32_t noise_count;  // candidates so far
    float shot_factor;          // of the pixel's shot noise, 1 without spread
    bool hot;
  };
  /// A pixel whose level may reach a threshold, or that has a noise candidate, in the interval.
  struct Active {
    std::uint32_t index;
    float luminance_before, luminance_now;
    float deviation_before, deviation_now;
    double log_before, log_now;
  };
  struct Interval {
    std::int64_t t0_us, t1_us;
    double duration_us;
    double before_us;  // t0 since the first image
  };
  /// Length of an interval in time constants of the photoreceptor: fixed + per_luminance * luminance.
  struct TimeConstants {
    double fixed, per_luminance;
  };
  struct Crossing {
    LevelPoint at;
    bool on;
  };

  void start(std::span<const float> luminance, std::int64_t t_us);
  /// Log luminances of as many pixels.
  void respond(std::span<const float> luminance, double* log_level) const;
  [[nodiscard]] double response(float luminance) const;
  [[nodiscard]] TimeConstants time_constants(const Interval& interval) const;
  void process_block(std::span<const float> luminance, std::size_t begin, const Interval& interval);
  void respond_where_active();
  // run_interval and run_trajectory: false where the pixel still waits at the end, in reset or for a free microsecond.
  void run_pixel(const Active& active, const Interval& interval, std::vector<PixelEvent>& events);
  [[nodiscard]] bool run_interval(const Active& active, const Interval& interval,
                                  std::vector<PixelEvent>& events);
  [[nodiscard]] bool run_trajectory(const Active& active, const LevelTrajectory& trajectory,
                                    const Interval& interval, LevelPoint& now,
                                    std::vector<PixelEvent>& events);
  [[nodiscard]] LevelTrajectory trajectory_of(const Active& active, const Interval& interval) const;
  [[nodiscard]] static bool next_crossing(const Pixel& pixel, const LevelTrajectory& trajectory,
                                          const LevelPoint& now, double to, Crossing& crossing);
  [[nodiscard]] bool leave_reset(std::size_t index, const LevelTrajectory& trajectory,
                                 const Interval& interval, LevelPoint& now);
  void next_noise(std::size_t index);
  [[nodiscard]] bool noise_fires(std::size_t index, double luminance, PixelEvent& event) const;
  [[nodiscard]] std::uint8_t object_at(std::size_t index) const;
  void set_bounds(std::size_t index, bool asleep);
  [[nodiscard]] float leak_per_us(std::size_t index, double luminance) const;
  void follow_light(std::span<const float> luminance, double before_us);
  [[nodiscard]] double on_rate_hz(const Pixel& p) const;

  EmulatorConfig config_;
  RandomStream random_;
  std::size_t first_;
  std::size_t count_;
  bool filtered_;
  bool held_;
  bool drops_;
  bool in_luminance_;  // low_ and high_ are luminances, otherwise levels
  bool started_ = false;
  std::int64_t start_us_ = 0;
  std::int64_t t_us_ = 0;
  std::vector<float> luminance_;  // of the newest image
  std::vector<float> deviation_;  // of the photoreceptor's output from the log luminance, at the newest image
  std::vector<float> low_, high_;  // a pixel whose level stays between them is quiet
  std::vector<float> leak_per_us_;
  std::vector<float> dark_leak_,
      light_leak_;  // level per us, and per us and luminance; empty where light adds none
  std::vector<std::int64_t> noise_due_us_;        // next noise candidate
  std::vector<std::int64_t> block_noise_due_us_;  // the first of each block
  std::vector<std::uint8_t> objects_;
  std::span<const std::uint8_t> objects_now_;
  LargeVector<Pixel> pixels_;
  std::vector<Active> active_;
  // Of the block at hand.
  std::array<double, block_size> log_{}, new_log_{};
  std::array<float, block_size> rise_{}, new_log_float_{}, new_deviation_{};
  std::array<std::uint32_t, block_size> quiet_{};
};

}  // namespace saccade
