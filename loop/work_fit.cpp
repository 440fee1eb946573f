#include "loop/work_fit.h"

#include <algorithm>
#include <cmath>

namespace saccade {
namespace {

/// Least squares of elapsed = per_call calls + per_event events, both at least 0.
WorkTime least_squares(const std::vector<WorkSample>& samples) {
  double cc = 0.0, ce = 0.0, ee = 0.0, ct = 0.0, et = 0.0;
  for (const WorkSample& sample : samples) {
    const auto calls = static_cast<double>(sample.calls);
    const auto events = static_cast<double>(sample.events);
    cc += calls * calls;
    ce += calls * events;
    ee += events * events;
    ct += calls * sample.elapsed_us;
    et += events * sample.elapsed_us;
  }
  const double determinant = cc * ee - ce * ce;
  if (determinant > 1e-9 * cc * ee) {
    const WorkTime both{(cc * et - ce * ct) / determinant, (ee * ct - ce * et) / determinant};
    if (both.per_event_us >= 0.0 && both.per_call_us >= 0.0) return both;
    if (both.per_call_us < 0.0) return {et / ee, 0.0};
  }
  return {0.0, cc > 0.0 ? ct / cc : 0.0};
}

double remainder_us(const WorkSample& sample, const WorkTime& work) {
  return std::abs(sample.elapsed_us - work.of(sample.calls, sample.events));
}

}  // namespace

WorkTime fit_work(std::vector<WorkSample> samples) {
  constexpr std::size_t kept_of_200 = 199;
  const WorkTime first = least_squares(samples);
  const auto end = samples.begin() + static_cast<std::ptrdiff_t>((samples.size() * kept_of_200 + 199) / 200);
  std::ranges::nth_element(samples, end, {},
                           [&](const WorkSample& sample) { return remainder_us(sample, first); });
  samples.erase(end, samples.end());
  return least_squares(samples);
}

void LatencyFit::on_tick(const Tick& tick) {
  for (std::size_t i = 0; i < samples_.size(); ++i) {
    const DetectorTick& result = tick.detectors[i];
    if (result.calls == 0) continue;
    samples_[i].push_back({result.calls, result.events, static_cast<double>(result.elapsed_ns) * 1e-3});
  }
  if (tick.step_ns > 0) steps_us_.push_back(static_cast<double>(tick.step_ns) * 1e-3);
}

LatencyConfig LatencyFit::latency() const {
  LatencyConfig latency;
  latency.kind = LatencyKind::model;
  for (std::size_t i = 0; i < samples_.size(); ++i)
    latency.detectors.emplace_back(loop_.detectors()[i].name, fit_work(samples_[i]));
  if (steps_us_.empty()) return latency;
  std::vector<double> steps_us = steps_us_;
  const auto middle = steps_us.begin() + static_cast<std::ptrdiff_t>(steps_us.size() / 2);
  std::ranges::nth_element(steps_us, middle);
  latency.controller_us = *middle;
  return latency;
}

}  // namespace saccade
