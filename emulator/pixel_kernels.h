#pragma once

#include <cstddef>
#include <cstdint>

// Loops over the pixels of a block, written so that the compiler vectorises them. Every array has n elements. The
// same input gives the same bits with every compiler and instruction set.
namespace saccade::emulator_kernels {

inline constexpr double darkest_luminance = 1e-9;   ///< smaller values count as this one
inline constexpr double min_time_constants = 1e-9;  ///< smallest length of an interval
inline constexpr double max_time_constants = 80.0;  ///< after so many the photoreceptor has settled

/// Parameters of an interval between two images, the same for all pixels.
struct Stage {
  float before_weight, now_weight;  ///< weights of the two images in the light that sets the time constant
  float per_light, fixed;           ///< time constants in the interval: fixed + per_light * light
  float ramp, step;                 ///< 1 and 0: the light changes in a straight line; 0 and 1: at the end
  float before_us, after_us;        ///< start and end of the interval since the first image, for leakage
};

/// log_level = ln(luminance + dark_current), to 1e-8. The logarithm of the mantissa in [sqrt(1/2), sqrt(2)) is a
/// minimax polynomial with an error below the rounding of a float; the exponent is added in double.
void log_of(const float* luminance, float dark_current, double* log_level, std::size_t n);

/// rise = log_now - log_before; now = log_now as a float.
void rises(const double* log_before, const double* log_now, float* rise, float* now, std::size_t n);

/// The first-order low-pass of the photoreceptor over the interval, as the deviation of its output from the light's
/// logarithm. With x the interval in time constants and q = 1 - exp(-x), the deviation d becomes
/// d exp(-x) - rise q / x for light that changes in a straight line, and d exp(-x) - rise for light that steps at the
/// end. quiet = 1 for pixels whose level stays inside (low, high): at the end of the interval and, where the level
/// has a turning point before it, up to the extreme of the light.
void low_pass(const Stage stage, const float* luminance_before, const float* luminance_now,
              const float* rises, const float* logs_now, const float* deviation_before, const float* low,
              const float* high, const float* leak_per_us, float* deviation, std::uint32_t* quiet,
              std::size_t n);

/// quiet without low-pass and leakage, compared in luminance: no logarithm is needed.
void compare(const float* luminance, const float* low, const float* high, std::uint32_t* quiet,
             std::size_t n);

/// quiet without low-pass: the output is the light's logarithm, a straight line or (`step`) constant and then a step.
void follow(const Stage stage, const double* log_before, const double* log_now, const float* low,
            const float* high, const float* leak_per_us, std::uint32_t* quiet, std::size_t n);

}  // namespace saccade::emulator_kernels
