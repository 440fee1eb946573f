#include "emulator/pixel_kernels.h"

#include <bit>

#include "core/vector_clones.h"

namespace saccade::emulator_kernels {

SACCADE_VECTOR_CLONES
void log_of(const float* luminance, float dark_current, double* log_level, std::size_t n) {
  constexpr float darkest = static_cast<float>(darkest_luminance);
  constexpr double ln2 = 0.693147180559945309417;
  for (std::size_t i = 0; i < n; ++i) {
    const float light = luminance[i] + dark_current;
    const float value = light > darkest ? light : darkest;
    const std::int32_t bits = std::bit_cast<std::int32_t>(value) - 0x3f3504f3;
    const float f = std::bit_cast<float>((bits & 0x007fffff) + 0x3f3504f3) - 1.0F;
    float p = 0.0867218822F;
    p = p * f - 0.143790081F;
    p = p * f + 0.149779931F;
    p = p * f - 0.165644258F;
    p = p * f + 0.199548751F;
    p = p * f - 0.250016987F;
    p = p * f + 0.333341658F;
    const float rest = (f * f) * (f * p - 0.5F);
    log_level[i] = static_cast<double>(static_cast<float>(bits >> 23)) * ln2 +
                   (static_cast<double>(f) + static_cast<double>(rest));
  }
}

SACCADE_VECTOR_CLONES
void rises(const double* log_before, const double* log_now, float* rise, float* now, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i) {
    rise[i] = static_cast<float>(log_now[i] - log_before[i]);
    now[i] = static_cast<float>(log_now[i]);
  }
}

SACCADE_VECTOR_CLONES
void low_pass(const Stage stage, const float* luminance_before, const float* luminance_now,
              const float* rises, const float* logs_now, const float* deviation_before, const float* low,
              const float* high, const float* leak_per_us, float* deviation, std::uint32_t* quiet,
              std::size_t n) {
  constexpr auto smallest = static_cast<float>(min_time_constants);
  constexpr auto largest = static_cast<float>(max_time_constants);
  constexpr float log2e = 1.44269504F;
  constexpr float ln2_high = 0.693145752F;
  constexpr float ln2_low = 1.42860677e-6F;
  constexpr float round = 12582912.0F;
  for (std::size_t i = 0; i < n; ++i) {
    float x = stage.fixed + stage.per_light * (stage.before_weight * luminance_before[i] +
                                               stage.now_weight * luminance_now[i]);
    x = x > smallest ? x : smallest;
    const float decay = x < largest ? x : largest;
    const float shifted = round - decay * log2e;
    const float k = shifted - round;
    const float r = (-decay - k * ln2_high) - k * ln2_low;
    float p = 0.00139464415F;
    p = p * r + 0.00836657826F;
    p = p * r + 0.0416662805F;
    p = p * r + 0.166665435F;
    p = p * r + 0.5F;
    const float grown = r + r * r * p;  // exp(r) - 1
    const float scale =
        std::bit_cast<float>((std::bit_cast<std::uint32_t>(shifted) - (0x4b400000U - 127U)) << 23U);
    const float q = (1.0F - scale) - scale * grown;

    const float rise = rises[i];
    const float d0 = deviation_before[i];
    const float d1 = (d0 - q * d0) - (stage.step + stage.ramp * (q / x)) * rise;
    deviation[i] = d1;

    const float now = logs_now[i];
    const float level = now + d1;
    const float turns = d0 * d1 < 0.0F ? 1.0F : 0.0F;
    const float up = rise > 0.0F ? rise : 0.0F;
    const float light_bottom = level - turns * (d1 + up);
    const float light_top = level - turns * (d1 + rise - up);
    const float top = (light_top > level ? light_top : level) + leak_per_us[i] * stage.after_us;
    const float bottom = (light_bottom < level ? light_bottom : level) + leak_per_us[i] * stage.before_us;
    quiet[i] = static_cast<std::uint32_t>(top < high[i]) & static_cast<std::uint32_t>(bottom > low[i]);
  }
}

SACCADE_VECTOR_CLONES
void compare(const float* luminance, const float* low, const float* high, std::uint32_t* quiet,
             std::size_t n) {
  for (std::size_t i = 0; i < n; ++i) {
    quiet[i] = static_cast<std::uint32_t>(luminance[i] < high[i]) &
               static_cast<std::uint32_t>(luminance[i] > low[i]);
  }
}

SACCADE_VECTOR_CLONES
void follow(const Stage stage, const double* log_before, const double* log_now, const float* low,
            const float* high, const float* leak_per_us, std::uint32_t* quiet, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i) {
    const auto now = static_cast<float>(log_now[i]);
    const float other = stage.step * static_cast<float>(log_before[i]) + stage.ramp * now;
    const float top = (other > now ? other : now) + leak_per_us[i] * stage.after_us;
    const float bottom = (other < now ? other : now) + leak_per_us[i] * stage.before_us;
    quiet[i] = static_cast<std::uint32_t>(top < high[i]) & static_cast<std::uint32_t>(bottom > low[i]);
  }
}

}  // namespace saccade::emulator_kernels
