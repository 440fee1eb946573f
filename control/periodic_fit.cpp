#include "control/periodic_fit.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace saccade {
namespace {

constexpr double average_s = RecentPath::spacing_s;
constexpr double lowest_hz = 0.4;
constexpr double scan_spacing_hz = 0.1;
constexpr double periods = 1.5;
constexpr double shortest_window_s = 0.6;
constexpr double least_amplitude_m = 0.01;
constexpr double least_explained = 0.92;
constexpr double kept_explained = 0.85;
constexpr int refinements_of_a_scan = 4;
constexpr std::int64_t averages_between_scans = 50;
constexpr double two_pi = 2.0 * std::numbers::pi;

}  // namespace

Eigen::Vector3d Sinusoid::position_m(double t_s) const {
  const double angle = two_pi * frequency_hz * (t_s - t0_s);
  return centre_m + cosine_m * std::cos(angle) + sine_m * std::sin(angle);
}

Eigen::Vector3d Sinusoid::velocity_m_s(double t_s) const {
  const double w = two_pi * frequency_hz;
  const double angle = w * (t_s - t0_s);
  return w * (sine_m * std::cos(angle) - cosine_m * std::sin(angle));
}

Eigen::Vector3d Sinusoid::acceleration_m_s2(double t_s) const {
  const double w = two_pi * frequency_hz;
  return -w * w * (position_m(t_s) - centre_m);
}

double Sinusoid::amplitude_m() const { return std::sqrt(cosine_m.squaredNorm() + sine_m.squaredNorm()); }

void PeriodicFit::clear() {
  sinusoid_.reset();
  start_scan();
  scanned_ = 0;
  refined_ = -1;
}

PeriodicFit::Candidate PeriodicFit::evaluate(const RecentPath& path, double frequency_hz) {
  const double window_s = std::max(shortest_window_s, periods / frequency_hz);
  const auto length = std::min(static_cast<std::int64_t>(std::lround(window_s / average_s)), path.length());
  Candidate found;
  found.sinusoid.frequency_hz = frequency_hz;
  found.sinusoid.t0_s = RecentPath::time_s(path.newest());
  found.periods = static_cast<double>(length) * average_s * frequency_hz;
  if (found.periods < 0.5) return found;

  const Eigen::Vector3d origin_m = path.at(0).point_m;
  const double step = two_pi * frequency_hz * average_s;
  const double turn_cos = std::cos(step), turn_sin = -std::sin(step);
  double c = 1.0, s = 0.0;
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();  // rows: 1, cos, sin
  double squares = 0.0;
  for (std::int64_t back = 0; back < length; ++back) {
    const RecentPath::Average& average = path.at(back);
    if (average.known) {
      const Eigen::Vector3d p = average.point_m - origin_m;
      const Eigen::Vector3d basis(1.0, c, s);
      normal += basis * basis.transpose();
      moments += basis * p.transpose();
      squares += p.squaredNorm();
    }
    const double next = c * turn_cos - s * turn_sin;
    s = c * turn_sin + s * turn_cos;
    c = next;
  }
  const double count = normal(0, 0);
  if (count < 0.7 * static_cast<double>(length)) return found;
  const double variance = squares - moments.row(0).squaredNorm() / count;
  const Eigen::Matrix3d coefficients = normal.inverse() * moments;
  if (!(variance > 0.0) || !coefficients.allFinite()) return found;
  const double left = squares - (coefficients.array() * moments.array()).sum();
  found.explained = 1.0 - left / variance;
  found.sinusoid.centre_m = origin_m + coefficients.row(0).transpose();
  found.sinusoid.cosine_m = coefficients.row(1).transpose();
  found.sinusoid.sine_m = coefficients.row(2).transpose();
  return found;
}

void PeriodicFit::search(const RecentPath& path) {
  if (path.newest() < 0) return;
  if (stage_ == Stage::scan) {
    scan(path);
  } else if (stage_ == Stage::refine || refined_ != path.newest()) {
    refine(path);
  }
}

void PeriodicFit::start_scan() {
  stage_ = Stage::scan;
  step_ = 0;
}

void PeriodicFit::scan(const RecentPath& path) {
  const Candidate next = evaluate(path, lowest_hz + scan_spacing_hz * step_);
  if (step_ == 0 || next.explained > best_.explained) best_ = next;
  if (++step_ < scan_steps) return;
  scanned_ = path.newest();
  step_ = 0;
  refinements_ = 0;
  spacing_hz_ = 0.5 * scan_spacing_hz;
  stage_ = Stage::refine;
}

/// Candidates on both sides of the best one, then the vertex of the parabola through the three.
void PeriodicFit::refine(const RecentPath& path) {
  const double f = best_.sinusoid.frequency_hz;
  if (step_ < 2) {
    sides_[static_cast<std::size_t>(step_)] = evaluate(path, f + (step_ == 0 ? -spacing_hz_ : spacing_hz_));
    ++step_;
    return;
  }
  step_ = 0;
  if (stage_ == Stage::follow) best_ = evaluate(path, f);
  const double below = sides_[0].explained, here = best_.explained, above = sides_[1].explained;
  const double bend = below - 2.0 * here + above;
  const double shift =
      bend < 0.0 ? std::clamp(0.5 * (below - above) / bend, -1.0, 1.0) : (above > below ? 1.0 : -1.0);
  best_ = evaluate(path, std::max(0.5 * lowest_hz, f + shift * spacing_hz_));
  refined_ = path.newest();
  if (stage_ == Stage::refine) {
    spacing_hz_ = std::max(0.02, 0.5 * spacing_hz_);
    if (++refinements_ < refinements_of_a_scan) return;
    stage_ = Stage::follow;
  }
  report(best_);
  if (!sinusoid_ || path.newest() - scanned_ >= averages_between_scans) start_scan();
}

void PeriodicFit::report(const Candidate& found) {
  const double least = sinusoid_ ? kept_explained : least_explained;
  if (found.periods >= 1.0 && found.explained >= least && found.sinusoid.amplitude_m() >= least_amplitude_m) {
    sinusoid_ = found.sinusoid;
  } else {
    sinusoid_.reset();
  }
}

}  // namespace saccade
