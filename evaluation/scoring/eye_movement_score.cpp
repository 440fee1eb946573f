#include "evaluation/scoring/eye_movement_score.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <span>

#include "core/units.h"

namespace saccade {
namespace {

using Samples = std::span<const EyeMovementSample>;
using Complex2 = Eigen::Vector2cd;

constexpr std::size_t most_samples = max_exact_values;
constexpr double moving_deg_s = 20.0;
constexpr double jump_deg_s = 100.0;
constexpr double least_jump_deg = 1.0;
constexpr double settled_deg = 1.0;
constexpr std::size_t first_step_ticks = 1000;
constexpr std::size_t jump_ticks = 100;
constexpr std::size_t answer_ticks = 700;
constexpr std::size_t between_jumps_ticks = 400;
constexpr std::size_t shortest_ramp_ticks = 200;
constexpr std::int64_t enough_saccades = 3;

double seconds(std::int64_t t_us) { return static_cast<double>(t_us) * 1e-6; }

Samples settled(const std::vector<EyeMovementSample>& samples) {
  const auto begin = std::ranges::lower_bound(samples, samples.front().t_us + eye_movements_settled_us, {},
                                              &EyeMovementSample::t_us);
  return {begin, samples.end()};
}

/// Complex amplitudes of both angles at a frequency, over the whole periods at the end; none if there is no whole period.
template <class Angles>
std::optional<Complex2> line(Samples samples, double frequency_hz, Angles angles) {
  if (samples.empty()) return std::nullopt;
  const double end_s = seconds(samples.back().t_us);
  const double periods = std::floor((end_s - seconds(samples.front().t_us)) * frequency_hz + 1e-6);
  if (periods < 1.0) return std::nullopt;
  const double begin_s = end_s - periods / frequency_hz;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  double count = 0.0;
  for (const EyeMovementSample& sample : samples) {
    if (seconds(sample.t_us) <= begin_s) continue;
    mean += angles(sample);
    ++count;
  }
  mean /= count;
  Complex2 sum = Complex2::Zero();
  for (const EyeMovementSample& sample : samples) {
    const double t_s = seconds(sample.t_us);
    if (t_s <= begin_s) continue;
    sum += (angles(sample) - mean) * std::polar(1.0, -2.0 * std::numbers::pi * frequency_hz * t_s);
  }
  return sum * (2.0 / count);
}

/// Of the angle in which the input is larger.
std::optional<std::complex<double>> ratio(const std::optional<Complex2>& output,
                                          const std::optional<Complex2>& input) {
  if (!output || !input) return std::nullopt;
  const int i = std::abs((*input)[0]) >= std::abs((*input)[1]) ? 0 : 1;
  if (std::abs((*input)[i]) < 1e-6) return std::nullopt;
  return (*output)[i] / (*input)[i];
}

Transfer transfer(double frequency_hz, std::complex<double> value) {
  return {frequency_hz, std::abs(value), std::arg(value) * deg_per_rad};
}

/// Velocity of an angle over 2 * half + 1 samples around i.
template <class Angles>
Eigen::Vector2d velocity(Samples samples, std::size_t i, std::size_t half, Angles angles) {
  const std::size_t low = i >= half ? i - half : 0;
  const std::size_t high = std::min(samples.size() - 1, i + half);
  return (angles(samples[high]) - angles(samples[low])) / seconds(samples[high].t_us - samples[low].t_us);
}

constexpr auto gaze_angles = [](const EyeMovementSample& sample) { return sample.gaze_deg; };
constexpr auto ball_angles = [](const EyeMovementSample& sample) { return sample.ball_deg; };

GazeStep step_at(Samples samples, std::size_t i, const Eigen::Vector2d& goal_deg) {
  const Eigen::Vector2d way_deg = goal_deg - samples[i].gaze_deg;
  const Eigen::Vector2d along = way_deg.normalized();
  GazeStep step;
  step.size_deg = way_deg.norm();
  std::size_t last_outside = i;
  const std::size_t end = std::min(i + answer_ticks, samples.size());
  for (std::size_t k = i; k < end; ++k) {
    const double since_ms = seconds(samples[k].t_us - samples[i].t_us) * 1e3;
    const double speed = along.dot(velocity(samples, k, 5, gaze_angles));
    if (speed > moving_deg_s && !step.latency_ms) step.latency_ms = since_ms;
    step.peak_deg_s = std::max(step.peak_deg_s, speed);
    if ((samples[k].gaze_deg - goal_deg).norm() > settled_deg) last_outside = k;
  }
  if (last_outside + 1 < end) step.settled_ms = seconds(samples[last_outside].t_us - samples[i].t_us) * 1e3;
  return step;
}

std::vector<GazeStep> steps_of(Samples samples) {
  std::vector<GazeStep> steps;
  for (std::size_t i = first_step_ticks; i + jump_ticks < samples.size(); ++i) {
    if (velocity(samples, i, 2, ball_angles).norm() < jump_deg_s) continue;
    const Eigen::Vector2d goal_deg = samples[i + jump_ticks].ball_deg;
    // A ball that goes on is no step.
    if (velocity(samples, i + jump_ticks, 5, ball_angles).norm() < 1.0 &&
        (goal_deg - samples[i].ball_deg).norm() >= least_jump_deg)
      steps.push_back(step_at(samples, i, goal_deg));
    i += between_jumps_ticks;
  }
  std::ranges::sort(steps, {}, &GazeStep::size_deg);
  return steps;
}

std::optional<GazeRamps> ramps_of(Samples samples) {
  constexpr std::size_t half = 50;
  std::vector<double> speeds;
  for (std::size_t i = 0; i < samples.size(); ++i)
    speeds.push_back(velocity(samples, i, half, ball_angles).norm());
  std::vector<double> sorted = speeds;
  const double fast = 0.7 * quantile(sorted, 0.9).value_or(0.0);
  if (fast < 1.0) return std::nullopt;
  GazeRamps ramps;
  bool first = true;
  for (std::size_t i = 0; i < speeds.size(); ++i) {
    const std::size_t begin = i;
    while (i < speeds.size() && speeds[i] > fast) ++i;
    if (i - begin < shortest_ramp_ticks) continue;
    if (std::exchange(first, false)) continue;
    const std::size_t from = (3 * begin + i) / 4;
    const std::size_t to = (begin + 3 * i) / 4;
    const double n = static_cast<double>(to - from);
    double ball_deg_s = 0.0;
    double gaze_deg_s = 0.0;
    double lag_deg = 0.0;
    for (std::size_t k = from; k < to; ++k) {
      const Eigen::Vector2d along = velocity(samples, k, half, ball_angles).normalized();
      ball_deg_s += speeds[k] / n;
      gaze_deg_s += along.dot(velocity(samples, k, half, gaze_angles)) / n;
      lag_deg += along.dot(samples[k].ball_deg - samples[k].gaze_deg) / n;
    }
    ++ramps.count;
    ramps.ball_deg_s += ball_deg_s;
    ramps.gain += gaze_deg_s / ball_deg_s;
    ramps.lag_deg += lag_deg;
  }
  if (ramps.count == 0) return std::nullopt;
  const double n = static_cast<double>(ramps.count);
  ramps.ball_deg_s /= n;
  ramps.gain /= n;
  ramps.lag_deg /= n;
  return ramps;
}

void fit_main_sequence(std::span<const Saccade> saccades, EyeMovementScore& score) {
  score.saccades = std::ssize(saccades);
  if (score.saccades < enough_saccades) return;
  const double n = static_cast<double>(saccades.size());
  double size = 0.0;
  double peak = 0.0;
  for (const Saccade& s : saccades) {
    size += s.amplitude_deg / n;
    peak += s.peak_deg_s / n;
  }
  double spread = 0.0;
  double common = 0.0;
  for (const Saccade& s : saccades) {
    spread += (s.amplitude_deg - size) * (s.amplitude_deg - size);
    common += (s.amplitude_deg - size) * (s.peak_deg_s - peak);
  }
  if (spread <= 0.0) return;
  score.main_sequence_per_s = common / spread;
  score.main_sequence_offset_deg_s = peak - common / spread * size;
}

}  // namespace

Eigen::Vector2d direction_deg(const Eigen::Vector3d& direction) {
  return deg_per_rad * Eigen::Vector2d(std::atan2(direction.y(), -direction.x()),
                                       std::atan2(direction.z(), std::hypot(direction.x(), direction.y())));
}

Eigen::Vector2d direction_in_camera_deg(const Eigen::Vector3d& point) {
  return deg_per_rad * Eigen::Vector2d(std::atan2(point.x(), point.z()), -std::atan2(point.y(), point.z()));
}

std::vector<double> image_speeds_px_s(const std::vector<std::int64_t>& t_us,
                                      const std::vector<Eigen::Vector2d>& image_px, std::int64_t from_us) {
  constexpr std::size_t over = 10;
  std::vector<double> speeds;
  for (std::size_t i = over; i < t_us.size(); ++i) {
    const double speed = (image_px[i] - image_px[i - over]).norm() / seconds(t_us[i] - t_us[i - over]);
    if (t_us[i] >= from_us && std::isfinite(speed)) speeds.push_back(speed);
  }
  return speeds;
}

SlipHistogram slip_histogram(const std::vector<double>& speeds_px_s) {
  SlipHistogram histogram;
  histogram.shares.assign(SlipHistogram::bins, 0.0);
  for (const double speed : speeds_px_s) {
    const auto bin = static_cast<std::size_t>(
        std::min(speed / SlipHistogram::width_px_s, static_cast<double>(SlipHistogram::bins - 1)));
    histogram.shares[bin] += 1.0 / static_cast<double>(speeds_px_s.size());
  }
  return histogram;
}

void EyeMovementScorer::add(const EyeMovementSample& sample, const Eigen::Vector3d& axis) {
  if (samples_.size() == most_samples) return;
  samples_.push_back(sample);
  finder_.add(sample.t_us, axis);
  if (finder_.count() > std::ssize(saccades_)) saccades_.emplace_back();
  if (!saccades_.empty()) saccades_.back() = finder_.newest();
}

EyeMovementScore EyeMovementScorer::score() const {
  EyeMovementScore score;
  if (samples_.size() <= first_step_ticks) return score;
  const Samples late = settled(samples_);
  if (protocol_.pursuit_hz) {
    const double hz = *protocol_.pursuit_hz;
    if (const auto value = ratio(line(late, hz, gaze_angles), line(late, hz, ball_angles))) {
      score.pursuit = transfer(hz, *value);
      score.pursuit_lag_ms = -score.pursuit->phase_deg / 360.0 / hz * 1e3;
    }
  }
  if (protocol_.sway_hz) {
    const double hz = *protocol_.sway_hz;
    const auto seen = line(late, hz, [](const EyeMovementSample& s) { return s.seen_deg; });
    const auto still = line(late, hz, [](const EyeMovementSample& s) { return s.still_deg; });
    if (const auto left = ratio(seen, still)) {
      score.stabilisation = transfer(hz, 1.0 - *left);
      score.slip_reduction = 1.0 - std::abs(*left);
    }
  }
  std::vector<double> errors;
  std::vector<std::int64_t> t_us;
  std::vector<Eigen::Vector2d> image_px;
  for (const EyeMovementSample& sample : late) {
    Eigen::Vector2d error = sample.ball_deg - sample.gaze_deg;
    error.x() *= std::cos(sample.ball_deg.y() * rad_per_deg);
    errors.push_back(error.norm());
    t_us.push_back(sample.t_us);
    image_px.push_back(sample.image_px);
  }
  score.error_deg = percentiles_of(errors);
  std::vector<double> speeds = image_speeds_px_s(t_us, image_px, 0);
  score.image_median_px_s = quantile(speeds, 0.5);
  score.image_p90_px_s = quantile(speeds, 0.9);
  score.steps = steps_of(samples_);
  if (!protocol_.pursuit_hz && !protocol_.sway_hz && score.steps.empty()) score.ramps = ramps_of(samples_);
  fit_main_sequence(saccades_, score);
  return score;
}

}  // namespace saccade
