#include "emulator/pixel_array.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/portable_math.h"
#include "emulator/event_label.h"
#include "emulator/pixel_kernels.h"

namespace saccade {
namespace {

using namespace emulator_kernels;

constexpr std::int64_t never_us = std::numeric_limits<std::int64_t>::min();
constexpr std::int64_t forever_us = std::numeric_limits<std::int64_t>::max();
constexpr double knee = 20.0;  ///< of lin_log, grey levels of 0..255
/// Farther in time than any event: 36,000 years. Sums and differences of two such times do not overflow.
constexpr double longest_us = 0x1p60;

// Counters of the random numbers of a pixel.
enum Draw : std::uint64_t {
  draw_on,
  draw_off,
  draw_leak,
  draw_phase,
  draw_hot,
  draw_leak_light,
  draw_leaky,
  draw_leaky_rate,
  draw_shot,
  draw_noise = 16
};

}  // namespace

PixelArray::PixelArray(const EmulatorConfig& config, std::size_t first, std::size_t count, std::uint64_t seed)
    : config_(config),
      random_(seed, "emulator"),
      first_(first),
      count_(count),
      filtered_(config.cutoff_hz > 0.0),
      held_(config.interpolation == Interpolation::held),
      drops_(config.refractory_mode == RefractoryMode::drop),
      in_luminance_(!filtered_ && !held_ && config.leak_rate_hz == 0.0 && config.leak_light_hz == 0.0 &&
                    config.leaky_pixel_share == 0.0 && config.response == LightResponse::log),
      luminance_(count),
      deviation_(filtered_ ? count : 0),
      low_(count),
      high_(count),
      leak_per_us_(count),
      dark_leak_(config.leak_light_hz > 0.0 ? count : 0),
      light_leak_(dark_leak_.size()),
      noise_due_us_(count, forever_us),
      block_noise_due_us_((count + block_size - 1) / block_size, forever_us),
      pixels_(count) {
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint64_t id = first + i;
    Pixel& p = pixels_[i];
    const auto threshold = [&](double nominal, Draw which) {
      const double factor = 1.0 + config.threshold_mismatch * random_.normal(id, which);
      return static_cast<float>(nominal * std::max(0.05, factor));
    };
    p.threshold_on = threshold(config.contrast_threshold_on, draw_on);
    p.threshold_off = threshold(config.contrast_threshold_off, draw_off);
    const auto log_normal = [&](double decades, Draw which) {
      return decades > 0.0 ? portable_exp(std::numbers::ln10 * decades * random_.normal(id, which)) : 1.0;
    };
    const double leak_hz = config.leak_rate_hz * log_normal(config.leak_spread_decades, draw_leak);
    p.leak_per_us = static_cast<float>(leak_hz * 1e-6) * p.threshold_on;
    if (config.leaky_pixel_share > 0.0 && random_.uniform(id, draw_leaky) < config.leaky_pixel_share) {
      const double faster = log_normal(config.leaky_pixel_spread_decades, draw_leaky_rate);
      p.leak_per_us += static_cast<float>(config.leaky_pixel_rate_hz * faster * 1e-6) * p.threshold_on;
    }
    leak_per_us_[i] = p.leak_per_us;
    if (!dark_leak_.empty()) {
      dark_leak_[i] = p.leak_per_us;
      const double light_hz =
          config.leak_light_hz * log_normal(config.leak_light_spread_decades, draw_leak_light);
      light_leak_[i] = static_cast<float>(light_hz * 1e-6 / config.white) * p.threshold_on;
    }
    p.hot = random_.uniform(id, draw_hot) < config.hot_pixel_share;
    p.shot_factor = static_cast<float>(log_normal(config.shot_noise_spread_decades, draw_shot));
    const double on_share = config.shot_noise_on_share;
    const double shot_hz =
        config.shot_noise_rate_hz * static_cast<double>(p.shot_factor) *
        (on_share * (config.contrast_threshold_on / static_cast<double>(p.threshold_on)) +
         (1.0 - on_share) * (config.contrast_threshold_off / static_cast<double>(p.threshold_off)));
    p.noise_rate_hz = static_cast<float>(shot_hz + (p.hot ? config.hot_pixel_rate_hz : 0.0));
  }
}

void PixelArray::start(std::span<const float> luminance, std::int64_t t_us) {
  std::copy(luminance.begin(), luminance.end(), luminance_.begin());
  for (std::size_t i = 0; i < count_; ++i) {
    Pixel& p = pixels_[i];
    p.leak_per_us = leak_per_us_[i] = leak_per_us(i, static_cast<double>(luminance[i]));
    // A leaking pixel starts at a random phase of its leakage.
    const double phase = p.leak_per_us > 0.0F ? random_.uniform(first_ + i, draw_phase) : 0.0;
    const double leaked = phase * static_cast<double>(p.threshold_on);
    p.reference = response(luminance[i]) - leaked;
    p.last_event_us = never_us;
    const double leaking_us = leaked > 0.0 ? leaked / static_cast<double>(p.leak_per_us) : 0.0;
    p.reset_until_us = t_us - static_cast<std::int64_t>(std::min(leaking_us, longest_us));
    p.noise_s = 0.0;
    p.noise_count = 0;
    set_bounds(i, false);
    if (p.noise_rate_hz > 0.0F) next_noise(i);
  }
}

void PixelArray::respond(std::span<const float> luminance, double* log_level) const {
  log_of(luminance.data(), static_cast<float>(config_.dark_current), log_level, luminance.size());
  if (config_.response == LightResponse::log) return;
  const double to_grey = 255.0 / config_.white;
  for (std::size_t i = 0; i < luminance.size(); ++i) {
    const double grey = static_cast<double>(luminance[i]) * to_grey;
    log_level[i] = grey <= knee ? grey * portable_log(knee) / knee : portable_log(grey);
  }
}

double PixelArray::response(float luminance) const {
  double log_level = 0.0;
  respond({&luminance, 1}, &log_level);
  return log_level;
}

void PixelArray::process(std::span<const float> luminance, std::span<const std::uint8_t> objects,
                         std::int64_t t_us, std::vector<PixelEvent>& events) {
  events.clear();
  if (!started_) {
    started_ = true;
    start_us_ = t_us;
    start(luminance, t_us);
  } else {
    const Interval interval{t_us_, t_us, static_cast<double>(t_us - t_us_),
                            static_cast<double>(t_us_ - start_us_)};
    objects_now_ = objects;
    if (!dark_leak_.empty()) follow_light(luminance, interval.before_us);
    active_.clear();
    for (std::size_t begin = 0; begin < count_; begin += block_size) {
      process_block(luminance.subspan(begin, std::min(block_size, count_ - begin)), begin, interval);
    }
    if (in_luminance_) respond_where_active();
    for (const Active& active : active_) run_pixel(active, interval, events);
  }
  t_us_ = t_us;
  objects_.assign(objects.begin(), objects.end());
}

float PixelArray::leak_per_us(std::size_t index, double luminance) const {
  if (dark_leak_.empty()) return leak_per_us_[index];
  return dark_leak_[index] + light_leak_[index] * static_cast<float>(luminance);
}

/// The leakage of the interval that begins: that of the mean light of its two images. Levels are with the leakage since the
/// first image, so a reference moves by what the change adds to that.
void PixelArray::follow_light(std::span<const float> luminance, double before_us) {
  for (std::size_t i = 0; i < count_; ++i) {
    const auto before = static_cast<double>(luminance_[i]);
    const double mean = held_ ? before : 0.5 * (before + static_cast<double>(luminance[i]));
    const float leak = leak_per_us(i, mean);
    Pixel& p = pixels_[i];
    if (leak == p.leak_per_us) continue;
    p.reference += (static_cast<double>(leak) - static_cast<double>(p.leak_per_us)) * before_us;
    p.leak_per_us = leak_per_us_[i] = leak;
    set_bounds(i, std::isinf(low_[i]));
  }
}

/// Of the photoreceptor in an interval: fixed + per_luminance * luminance.
PixelArray::TimeConstants PixelArray::time_constants(const Interval& interval) const {
  const double at_white = 2.0 * std::numbers::pi * config_.cutoff_hz * interval.duration_us * 1e-6;
  if (!config_.cutoff_follows_light) return {at_white, 0.0};
  const double per_light = at_white / (config_.white + config_.dark_current);
  return {per_light * config_.dark_current, per_light};
}

void PixelArray::process_block(std::span<const float> luminance, std::size_t begin,
                               const Interval& interval) {
  const std::size_t n = luminance.size();
  const TimeConstants constants = time_constants(interval);
  const Stage stage{.before_weight = held_ ? 1.0F : 0.5F,
                    .now_weight = held_ ? 0.0F : 0.5F,
                    .per_light = static_cast<float>(constants.per_luminance),
                    .fixed = static_cast<float>(constants.fixed),
                    .ramp = held_ ? 0.0F : 1.0F,
                    .step = held_ ? 1.0F : 0.0F,
                    .before_us = static_cast<float>(interval.before_us),
                    .after_us = static_cast<float>(interval.before_us + interval.duration_us)};
  const std::span<float> before = std::span(luminance_).subspan(begin, n);
  const float* const low = low_.data() + begin;
  const float* const high = high_.data() + begin;
  const float* const leak = leak_per_us_.data() + begin;
  if (in_luminance_) {
    compare(luminance.data(), low, high, quiet_.data(), n);
  } else {
    respond(before, log_.data());
    respond(luminance, new_log_.data());
    if (filtered_) {
      rises(log_.data(), new_log_.data(), rise_.data(), new_log_float_.data(), n);
      low_pass(stage, before.data(), luminance.data(), rise_.data(), new_log_float_.data(),
               deviation_.data() + begin, low, high, leak, new_deviation_.data(), quiet_.data(), n);
    } else {
      follow(stage, log_.data(), new_log_.data(), low, high, leak, quiet_.data(), n);
    }
  }
  std::int64_t& noise_due_us = block_noise_due_us_[begin / block_size];
  if (noise_due_us <= interval.t1_us) {
    noise_due_us = forever_us;  // the active pixels lower it again
    for (std::size_t k = 0; k < n; ++k) {
      const std::int64_t due_us = noise_due_us_[begin + k];
      if (due_us <= interval.t1_us)
        quiet_[k] = 0;
      else
        noise_due_us = std::min(noise_due_us, due_us);
    }
  }
  std::fill(quiet_.begin() + static_cast<std::ptrdiff_t>(n), quiet_.end(), 1U);
  for (std::size_t group = 0; group < n; group += 8) {
    std::uint32_t all_quiet = 1;
    for (std::size_t k = group; k < group + 8; ++k) all_quiet &= quiet_[k];
    if (all_quiet != 0) continue;
    for (std::size_t k = group; k < group + 8; ++k) {
      if (quiet_[k] != 0) continue;
      const auto index = static_cast<std::uint32_t>(begin + k);
      active_.push_back({index, before[k], luminance[k], filtered_ ? deviation_[index] : 0.0F,
                         new_deviation_[k], log_[k], new_log_[k]});
#if defined(__GNUC__)
      __builtin_prefetch(&pixels_[index], 1);
      __builtin_prefetch(&noise_due_us_[index], 1);
#endif
    }
  }
  std::copy(luminance.begin(), luminance.end(), before.begin());
  if (filtered_) std::copy_n(new_deviation_.begin(), n, deviation_.data() + begin);
}

/// The log luminances of the active pixels, where the comparison was in luminance.
void PixelArray::respond_where_active() {
  std::array<float, block_size> luminance;
  for (std::size_t begin = 0; begin < active_.size(); begin += block_size / 2) {
    const std::span<Active> some =
        std::span(active_).subspan(begin, std::min(block_size / 2, active_.size() - begin));
    for (std::size_t j = 0; j < some.size(); ++j) {
      luminance[2 * j] = some[j].luminance_before;
      luminance[2 * j + 1] = some[j].luminance_now;
    }
    respond(std::span(luminance).first(2 * some.size()), log_.data());
    for (std::size_t j = 0; j < some.size(); ++j) {
      some[j].log_before = log_[2 * j];
      some[j].log_now = log_[2 * j + 1];
    }
  }
}

/// Exponential intervals: a Poisson process of candidates whose rate does not depend on the light.
void PixelArray::next_noise(std::size_t index) {
  Pixel& p = pixels_[index];
  const double uniform = random_.uniform(first_ + index, draw_noise + 4 * p.noise_count);
  p.noise_s -= portable_log(1.0 - uniform) / static_cast<double>(p.noise_rate_hz);
  ++p.noise_count;
  const double due_us = std::min(std::ceil(p.noise_s * 1e6), longest_us);
  noise_due_us_[index] = start_us_ + static_cast<std::int64_t>(due_us);
  std::int64_t& block_due_us = block_noise_due_us_[index / block_size];
  block_due_us = std::min(block_due_us, noise_due_us_[index]);
}

/// Shot noise in the dark.
double PixelArray::on_rate_hz(const Pixel& p) const {
  return config_.shot_noise_on_share * config_.shot_noise_rate_hz * config_.contrast_threshold_on /
         static_cast<double>(p.threshold_on) * static_cast<double>(p.shot_factor);
}

/// Whether the candidate before the next one becomes an event at that luminance; and which.
bool PixelArray::noise_fires(std::size_t index, double luminance, PixelEvent& event) const {
  const Pixel& p = pixels_[index];
  const std::uint64_t counter = draw_noise + 4 * (p.noise_count - 1);
  const double which = random_.uniform(first_ + index, counter + 1) * static_cast<double>(p.noise_rate_hz);
  if (p.hot && which < config_.hot_pixel_rate_hz) {
    event.on = true;
    event.cause = static_cast<std::uint8_t>(EventCause::hot);
    return true;
  }
  event.on = which - (p.hot ? config_.hot_pixel_rate_hz : 0.0) < on_rate_hz(p);
  event.cause = static_cast<std::uint8_t>(EventCause::shot);
  const double chance = random_.uniform(first_ + index, counter + 2);
  if (config_.shot_noise_light > 0.0) {
    return chance < portable_exp(-std::min(700.0, luminance / config_.shot_noise_light));
  }
  const double grey = luminance * 255.0 / config_.white;
  const double brightness = std::min(1.0, (grey + 20.0) / 275.0);
  return chance < 1.0 - 0.75 * brightness;
}

LevelTrajectory PixelArray::trajectory_of(const Active& active, const Interval& interval) const {
  const double leak = static_cast<double>(pixels_[active.index].leak_per_us);
  const double rise = held_ ? 0.0 : active.log_now - active.log_before;
  LevelTrajectory c{};
  c.end_us = interval.duration_us;
  c.start = c.level = active.log_before;
  c.end = active.log_before + rise;
  if (filtered_) {
    const auto before = static_cast<double>(active.luminance_before);
    const double mean = held_ ? before : 0.5 * (before + static_cast<double>(active.luminance_now));
    const TimeConstants constants = time_constants(interval);
    const double x = std::max(constants.fixed + constants.per_luminance * mean, min_time_constants);
    c.rate = x / interval.duration_us;
    c.amplitude = static_cast<double>(active.deviation_before) + rise / x;
    c.start = active.log_before - rise / x;
    c.level = active.log_before + static_cast<double>(active.deviation_before);
    c.end = active.log_now + static_cast<double>(active.deviation_now);
  }
  c.level += leak * interval.before_us;
  c.slope = rise / interval.duration_us + leak;
  c.start += leak * interval.before_us;
  c.end += leak * (interval.before_us + interval.duration_us);
  return c;
}

bool PixelArray::next_crossing(const Pixel& p, const LevelTrajectory& trajectory, const LevelPoint& now,
                               double to, Crossing& crossing) {
  const double high = p.reference + static_cast<double>(p.threshold_on);
  const double low = p.reference - static_cast<double>(p.threshold_off);
  if (now.level >= high || now.level <= low) {  // a crowded microsecond pushed it into this interval
    crossing = {now, now.level >= high};
    return true;
  }
  LevelPoint from = now;
  for (const double end_us : {std::min(trajectory.turn_after(from.u_us), to), to}) {
    const LevelPoint end{end_us, trajectory.at(end_us)};
    if (end.level >= high || end.level <= low) {
      const double target = end.level >= high ? high : low;
      crossing = {{trajectory.time_of(target, from, end), target}, end.level >= high};
      return true;
    }
    if (end_us == to) return false;
    from = end;
  }
  return false;
}

void PixelArray::run_pixel(const Active& active, const Interval& interval, std::vector<PixelEvent>& events) {
  const bool asleep = !run_interval(active, interval, events);
  while (noise_due_us_[active.index] <= interval.t1_us)
    next_noise(active.index);  // those of a pixel in reset
  set_bounds(active.index, asleep);
}

bool PixelArray::run_interval(const Active& active, const Interval& interval,
                              std::vector<PixelEvent>& events) {
  const Pixel& p = pixels_[active.index];
  if (p.reset_until_us > interval.t1_us) return false;
  const LevelTrajectory trajectory = trajectory_of(active, interval);
  LevelPoint now{0.0, trajectory.level};
  if (p.reset_until_us > interval.t0_us && !leave_reset(active.index, trajectory, interval, now))
    return false;
  if (!run_trajectory(active, trajectory, interval, now, events)) return false;
  if (!held_ || filtered_) return true;
  LevelTrajectory step = trajectory;
  step.slope = 0.0;
  step.end =
      active.log_now + static_cast<double>(p.leak_per_us) * (interval.before_us + interval.duration_us);
  now = {interval.duration_us, step.end};
  return run_trajectory(active, step, interval, now, events);
}

/// False when the reset lasts beyond the interval.
bool PixelArray::leave_reset(std::size_t index, const LevelTrajectory& trajectory, const Interval& interval,
                             LevelPoint& now) {
  Pixel& p = pixels_[index];
  if (p.reset_until_us > interval.t1_us) return false;
  while (noise_due_us_[index] <= p.reset_until_us) next_noise(index);
  now.u_us = static_cast<double>(p.reset_until_us - interval.t0_us);
  now.level = p.reference = trajectory.at(now.u_us);
  return true;
}

bool PixelArray::run_trajectory(const Active& active, const LevelTrajectory& trajectory,
                                const Interval& interval, LevelPoint& now, std::vector<PixelEvent>& events) {
  const std::size_t index = active.index;
  Pixel& p = pixels_[index];
  for (;;) {
    const std::int64_t noise_us = noise_due_us_[index];
    const bool noise = noise_us <= interval.t1_us;
    const double to = noise ? static_cast<double>(noise_us - interval.t0_us) : trajectory.end_us;
    PixelEvent event;
    event.pixel = static_cast<std::uint32_t>(first_ + index);
    event.object = object_at(index);
    Crossing crossing{};
    if (next_crossing(p, trajectory, now, to, crossing)) {
      event.on = crossing.on;
      event.t_us =
          interval.t0_us + std::max<std::int64_t>(1, static_cast<std::int64_t>(std::ceil(crossing.at.u_us)));
      if (event.t_us <= p.last_event_us) event.t_us = p.last_event_us + 1;
      if (event.t_us > interval.t1_us) return false;  // no free microsecond left: found again in the next one
      const double leaked =
          static_cast<double>(p.leak_per_us) * static_cast<double>(event.t_us - p.reset_until_us);
      if (crossing.on && leaked > 0.5 * static_cast<double>(p.threshold_on)) {
        event.cause = static_cast<std::uint8_t>(EventCause::leak);
      }
      now = crossing.at;
      p.reference +=
          crossing.on ? static_cast<double>(p.threshold_on) : -static_cast<double>(p.threshold_off);
    } else if (noise) {
      now = {to, trajectory.at(to)};
      next_noise(index);
      const double share = to / interval.duration_us;
      const auto before = static_cast<double>(active.luminance_before);
      const double light =
          before + (held_ ? 0.0 : share * (static_cast<double>(active.luminance_now) - before));
      event.t_us = noise_us;
      if (noise_us <= p.last_event_us || !noise_fires(index, light, event)) continue;
      p.reference = now.level;
    } else {
      return true;
    }
    if (drops_ && p.last_event_us != never_us && event.t_us < p.last_event_us + config_.refractory_us)
      continue;
    events.push_back(event);
    p.last_event_us = p.reset_until_us = event.t_us;
    if (config_.refractory_us > 0 && !drops_) {
      p.reset_until_us += config_.refractory_us;
      if (!leave_reset(index, trajectory, interval, now)) return false;
    }
  }
}

std::uint8_t PixelArray::object_at(std::size_t index) const {
  if (objects_now_.empty()) return 0;
  return objects_.empty() ? objects_now_[index] : std::min(objects_[index], objects_now_[index]);
}

void PixelArray::set_bounds(std::size_t index, bool asleep) {
  constexpr float infinity = std::numeric_limits<float>::infinity();
  const Pixel& p = pixels_[index];
  const auto bound = [&](double level, double inwards) {  // safely on the quiet side after rounding
    level += inwards * 2e-6 * (1.0 + std::abs(level));
    return static_cast<float>(in_luminance_ ? portable_exp(level) - config_.dark_current : level);
  };
  high_[index] = asleep ? -infinity : bound(p.reference + static_cast<double>(p.threshold_on), -1.0);
  low_[index] = asleep ? infinity : bound(p.reference - static_cast<double>(p.threshold_off), 1.0);
}

double PixelArray::output_log(std::size_t index) const {
  return response(luminance_[index]) + (filtered_ ? static_cast<double>(deviation_[index]) : 0.0);
}

double PixelArray::reference_log(std::size_t index) const {
  return pixels_[index].reference -
         static_cast<double>(pixels_[index].leak_per_us) * static_cast<double>(t_us_ - start_us_);
}

}  // namespace saccade
