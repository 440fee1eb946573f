#include "emulator/event_emulator.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "core/random.h"

namespace saccade {
namespace {

constexpr std::int64_t never_us = std::numeric_limits<std::int64_t>::min();

/// ln of positive, normal numbers to 2e-15 by range reduction and the series of the inverse hyperbolic
/// tangent: the same bits from every compiler and vector width, unlike the library's.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
__attribute__((target_clones("avx2", "default")))
#endif
void log_image(const float* luminance, double dark_current, double* out, std::size_t n) {
  constexpr double ln2 = 0.693147180559945309417;
  for (std::size_t i = 0; i < n; ++i) {
    const double value = static_cast<double>(luminance[i]) + dark_current;
    // value = m 2^e with m in [sqrt(1/2), sqrt(2))
    const std::uint64_t bits = std::bit_cast<std::uint64_t>(value) - 0x3fe6a09e667f3bcdULL;
    const double m = std::bit_cast<double>((bits & 0x000fffffffffffffULL) + 0x3fe6a09e667f3bcdULL);
    // The exponent as a double without a 64-bit integer conversion, which SSE and AVX2 lack.
    const double e =
        std::bit_cast<double>((((bits >> 52) + 1024) & 0x7ff) | 0x4330000000000000ULL) - (0x1.0p52 + 1024.0);
    const double s = (m - 1.0) / (m + 1.0);
    const double z = s * s;
    double series = 1.0 / 17;
    for (int odd = 15; odd >= 1; odd -= 2) series = series * z + 1.0 / odd;
    out[i] = e * ln2 + 2.0 * s * series;
  }
}

}  // namespace

const std::vector<std::string>& emulator_presets() {
  static const std::vector<std::string> names = {"ideal", "dvs128"};
  return names;
}

EmulatorConfig emulator_preset(const std::string& name) {
  EmulatorConfig config;
  config.preset = name;
  if (name == "ideal") {
    config.threshold_mismatch = 0.0;
    config.refractory_us = 0;
  } else if (name != "dvs128") {
    throw InputError("emulator.preset", name, expectation_of(emulator_presets()));
  }
  return config;
}

void describe(FieldVisitor& v, EmulatorConfig& config) {
  const std::string preset = config.preset;
  v.choice("preset", config.preset, emulator_presets(), "pixel model that the keys below start from");
  const auto& known = emulator_presets();
  if (config.preset != preset && std::find(known.begin(), known.end(), config.preset) != known.end()) {
    config = emulator_preset(config.preset);
  }
  v.real("contrast_threshold_on", config.contrast_threshold_on, {0.01, 5.0},
         "rise of ln luminance per event");
  v.real("contrast_threshold_off", config.contrast_threshold_off, {0.01, 5.0},
         "fall of ln luminance per event");
  v.real("threshold_mismatch", config.threshold_mismatch, {0.0, 0.5}, "relative sigma over pixels");
  v.integer("refractory_us", config.refractory_us, {0, 1e6}, "pixel held in reset after an event");
  v.real("dark_current", config.dark_current, {1e-3, 255.0}, "added to luminance, grey levels of 0..255");
}

EventEmulator::EventEmulator(const EmulatorConfig& config, ImageSize size, std::uint64_t seed)
    : config_(config), size_(size) {
  check_config("emulator", config);
  SACCADE_CHECK(size.width > 0 && size.height > 0 && size.width <= 65535 && size.height <= 65535);
  const auto n = static_cast<std::size_t>(size.pixels());
  const RandomStream random(seed, "emulator");
  threshold_on_.resize(n);
  threshold_off_.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const auto factor = [&](std::uint64_t which) {
      return std::max(0.05, 1.0 + config.threshold_mismatch * random.normal(i, which));
    };
    threshold_on_[i] = config.contrast_threshold_on * factor(0);
    threshold_off_[i] = config.contrast_threshold_off * factor(1);
  }
  log_before_.resize(n);
  log_now_.resize(n);
  reference_.resize(n);
  last_event_us_.assign(n, never_us);
  reset_until_us_.assign(n, never_us);
}

void EventEmulator::process_image(std::span<const float> luminance, std::int64_t t_us,
                                  std::vector<Event>& events) {
  const std::size_t n = log_now_.size();
  SACCADE_CHECK(luminance.size() == n);
  if (started_ && t_us <= t_us_) {
    throw InputError("image at " + std::to_string(t_us) + " us", "time that does not advance",
                     "a time after " + std::to_string(t_us_) + " us");
  }
  for (std::size_t i = 0; i < n; ++i) {
    if (!(luminance[i] >= 0.0F && luminance[i] <= std::numeric_limits<float>::max())) {
      const auto width = static_cast<std::size_t>(size_.width);
      throw InputError("image at " + std::to_string(t_us) + " us, pixel (" + std::to_string(i % width) +
                           ", " + std::to_string(i / width) + ")",
                       text_of(static_cast<double>(luminance[i])), "a finite luminance of at least 0");
    }
  }
  if (!started_) {
    log_image(luminance.data(), config_.dark_current, log_now_.data(), n);
    reference_ = log_now_;
    started_ = true;
    t_us_ = t_us;
    return;
  }
  std::swap(log_before_, log_now_);
  log_image(luminance.data(), config_.dark_current, log_now_.data(), n);
  unsorted_.clear();
  for (std::size_t i = 0; i < n; ++i) {
    const double low = reference_[i] - threshold_off_[i];
    const double high = reference_[i] + threshold_on_[i];
    const double now = log_now_[i];
    if ((now < high && now > low) && reset_until_us_[i] <= t_us_) continue;
    emit_pixel(i, t_us_, t_us);
  }
  sort_into(events, t_us_, t_us);
  t_us_ = t_us;
}

void EventEmulator::emit_pixel(std::size_t i, std::int64_t t0, std::int64_t t1) {
  const double l0 = log_before_[i];
  const double l1 = log_now_[i];
  const double duration = static_cast<double>(t1 - t0);
  const auto level_at = [&](std::int64_t t) {
    return t == t1 ? l1 : l0 + (l1 - l0) * (static_cast<double>(t - t0) / duration);
  };
  if (reset_until_us_[i] > t0) {
    if (reset_until_us_[i] > t1) return;
    reference_[i] = level_at(reset_until_us_[i]);
  }
  for (;;) {
    const bool on = l1 >= reference_[i] + threshold_on_[i];
    const bool off = l1 <= reference_[i] - threshold_off_[i];
    if (!on && !off) return;
    const double target = on ? reference_[i] + threshold_on_[i] : reference_[i] - threshold_off_[i];
    // Passed before t0 already when a crowded microsecond pushed it into this interval.
    const bool overdue = on ? l0 >= target : l0 <= target;
    const double crossing = overdue ? 0.0 : (target - l0) / (l1 - l0) * duration;
    std::int64_t t = t0 + std::max<std::int64_t>(1, static_cast<std::int64_t>(std::ceil(crossing)));
    t = std::max(std::min(t, t1), last_event_us_[i] == never_us ? t0 + 1 : last_event_us_[i] + 1);
    if (t > t1) return;  // no free microsecond left: found again with the next image
    const auto width = static_cast<std::size_t>(size_.width);
    unsorted_.push_back(
        {t, static_cast<std::uint16_t>(i % width), static_cast<std::uint16_t>(i / width), on, 0});
    last_event_us_[i] = t;
    reference_[i] = target;
    if (config_.refractory_us > 0) {
      reset_until_us_[i] = t + config_.refractory_us;
      if (reset_until_us_[i] > t1) return;
      reference_[i] = level_at(reset_until_us_[i]);
    }
  }
}

void EventEmulator::sort_into(std::vector<Event>& events, std::int64_t t0, std::int64_t t1) {
  const std::size_t before = events.size();
  const std::size_t n = unsorted_.size();
  event_count_ += static_cast<std::int64_t>(n);
  if (t1 - t0 > 100'000) {
    events.insert(events.end(), unsorted_.begin(), unsorted_.end());
    std::stable_sort(events.begin() + static_cast<std::ptrdiff_t>(before), events.end(),
                     [](const Event& a, const Event& b) { return a.t_us < b.t_us; });
    return;
  }
  first_at_.assign(static_cast<std::size_t>(t1 - t0) + 1, 0);  // slot k: events of t0 + k + 1
  for (const Event& e : unsorted_) ++first_at_[static_cast<std::size_t>(e.t_us - t0)];
  for (std::size_t k = 1; k < first_at_.size(); ++k) first_at_[k] += first_at_[k - 1];
  events.resize(before + n);
  for (const Event& e : unsorted_)
    events[before + first_at_[static_cast<std::size_t>(e.t_us - t0) - 1]++] = e;
}

}  // namespace saccade
