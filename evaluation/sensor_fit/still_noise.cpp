#include "evaluation/sensor_fit/still_noise.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace saccade {
namespace {

// Levels are in standard deviations of the noise, times in its time constants.
constexpr double spacing = 0.25;      ///< of the levels of the grid
constexpr double beyond = 2.5;        ///< references that far beyond the larger threshold are not modelled
constexpr double least_spread = 0.4;  ///< of the reference after an event, in spacings
constexpr double negligible = 1e-9;   ///< share of intervals
constexpr double never = 1e300;

/// The time until noise that starts at a reference has passed a threshold: for each way out a sum of decaying exponentials.
struct Passage {
  Eigen::VectorXd rates;               // ascending; the first is that of a long wait
  std::array<Eigen::VectorXd, 2> out;  // density of ON and OFF at time 0 of each exponential

  [[nodiscard]] double share(std::size_t way, Eigen::Index k) const { return out[way][k] / rates[k]; }
};

/// Integral of exp((x^2 - zero^2) / 2) from a to b, of exp(-(x^2 - zero^2) / 2) with sign -1.
double integral(double a, double b, double zero, double sign) {
  const auto f = [&](double x) { return std::exp(0.5 * sign * (x * x - zero * zero)); };
  constexpr int parts = 4;
  const double h = (b - a) / parts;
  double sum = 0.0;
  for (int i = 0; i < parts; ++i) sum += f(a + i * h) + 4.0 * f(a + (i + 0.5) * h) + f(a + (i + 1) * h);
  return sum * h / 6.0;
}

/// The noise as a chain of steps between neighbouring levels that has the right ways out and the right distribution.
Passage passage(double reference, double on, double off) {
  const auto up = static_cast<int>(std::ceil(on / spacing)),
             down = static_cast<int>(std::ceil(off / spacing));
  const int n = up + down - 1;
  const auto level = [&](int i) {  // -1: the lower threshold, n: the upper one
    const int from_start = i - (down - 1);
    return reference + (from_start < 0 ? off / down : on / up) * from_start;
  };
  std::vector<double> conductance(static_cast<std::size_t>(n) + 1), mass(static_cast<std::size_t>(n));
  for (int i = 0; i <= n; ++i)
    conductance[static_cast<std::size_t>(i)] = 1.0 / integral(level(i - 1), level(i), reference, 1.0);
  for (int i = 0; i < n; ++i)
    mass[static_cast<std::size_t>(i)] =
        integral(0.5 * (level(i - 1) + level(i)), 0.5 * (level(i) + level(i + 1)), reference, -1.0);
  Eigen::VectorXd diagonal(n), beside(std::max(1, n - 1));
  for (int i = 0; i < n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    diagonal[i] = (conductance[k] + conductance[k + 1]) / mass[k];
    if (i + 1 < n) beside[i] = -conductance[k + 1] / std::sqrt(mass[k] * mass[k + 1]);
  }
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver;
  solver.computeFromTridiagonal(diagonal, beside.head(n - 1));
  const Eigen::MatrixXd& q = solver.eigenvectors();
  const int start = down - 1;
  const Eigen::VectorXd at_start =
      q.row(start).transpose() / std::sqrt(mass[static_cast<std::size_t>(start)]);
  Passage p;
  p.rates = solver.eigenvalues().cwiseMax(1e-14);
  p.out[0] = (conductance.back() / std::sqrt(mass.back())) * q.row(n - 1).transpose().cwiseProduct(at_start);
  p.out[1] = (conductance.front() / std::sqrt(mass.front())) * q.row(0).transpose().cwiseProduct(at_start);

  // The long wait from the exact shares of the ways out and the exact mean time: eigenvectors do not resolve events in
  // more than 10^12 time constants.
  std::vector<double> below(static_cast<std::size_t>(n) +
                            1);  // resistance from the lower threshold to a level
  double resistance = 0.0;
  for (std::size_t i = 0; i < below.size(); ++i) below[i] = resistance += 1.0 / conductance[i];
  const double to_start = below[static_cast<std::size_t>(start)];
  double mean = 0.0;
  for (std::size_t i = 0; i < mass.size(); ++i)
    mean += mass[i] * std::min(below[i], to_start) * (resistance - std::max(below[i], to_start)) / resistance;
  std::array<double, 2> share{to_start / resistance, 1.0 - to_start / resistance};
  for (Eigen::Index k = 1; k < p.rates.size(); ++k) {
    for (const std::size_t way : {0U, 1U}) share[way] -= p.share(way, k);
    mean -= (p.share(0, k) + p.share(1, k)) / p.rates[k];
  }
  share = {std::max(0.0, share[0]), std::max(0.0, share[1])};
  if (mean > 0.0 && share[0] + share[1] > negligible) {
    p.rates[0] = (share[0] + share[1]) / mean;
    for (const std::size_t way : {0U, 1U}) p.out[way][0] = share[way] * p.rates[0];
  }
  return p;
}

struct Grid {
  double low = 0.0;
  std::size_t size = 0;
  [[nodiscard]] double at(std::size_t i) const { return low + spacing * static_cast<double>(i); }
};

/// Adds `share` of a normal distribution to a row over the grid.
template <class Row>
void add_normal(const Grid& grid, double mean, double spread, double share, Row&& row) {
  const auto below = [&](double x) { return 0.5 * std::erfc((mean - x) / (spread * std::numbers::sqrt2)); };
  double last = 0.0;  // the outer levels hold what lies outside
  for (std::size_t i = 0; i < grid.size; ++i) {
    const double next = i + 1 == grid.size ? 1.0 : below(grid.at(i) + 0.5 * spacing);
    row[static_cast<Eigen::Index>(i)] += share * (next - last);
    last = next;
  }
}

/// From a reference: the share of intervals of each polarity that end in each bin, and the mean interval without the
/// refractory period.
class IntervalsFrom {
 public:
  /// `edges`: of the bins, after the refractory period, in time constants.
  explicit IntervalsFrom(std::span<const double> edges) : edges_(edges) {
    for (auto& s : shares) s.assign(edges.size() - 1, 0.0);
  }
  /// Shares of intervals that end at `rate` between two times, ON and OFF.
  void add(std::array<double, 2> share, double rate, double begin, double end) {
    constexpr double all_gone = 40.0;
    const auto left = [&](double t) { return std::exp(-std::min(all_gone, rate * (t - begin))); };
    double before = left(std::clamp(edges_.front(), begin, end));
    for (std::size_t b = 0; b + 1 < edges_.size() && edges_[b] < end; ++b) {
      if (edges_[b + 1] <= begin) continue;
      const double after = left(std::min(edges_[b + 1], end));
      shares[0][b] += share[0] * (before - after);
      shares[1][b] += share[1] * (before - after);
      if (rate * (edges_[b + 1] - begin) > all_gone) break;
      before = after;
    }
  }
  std::array<std::vector<double>, 2> shares;
  double mean = 0.0;

 private:
  std::span<const double> edges_;
};

}  // namespace

StillRates still_rates(const StillNoise& noise, std::span<const double> edges_s) {
  const double refractory = noise.refractory_s / noise.time_constant_s;
  const double leak = noise.on * noise.leak_hz * noise.time_constant_s;  // of the reference
  const double farthest = std::max(noise.on, noise.off) + beyond;
  const Grid grid{-farthest, static_cast<std::size_t>(std::ceil(2.0 * farthest / spacing)) + 1};
  std::vector<double> edges(edges_s.begin(), edges_s.end());
  for (double& e : edges) e = e / noise.time_constant_s - refractory;

  std::vector<Passage> passages;
  for (std::size_t j = 0; j < grid.size; ++j) passages.push_back(passage(grid.at(j), noise.on, noise.off));

  // Where an event leaves the reference.
  const auto n = static_cast<Eigen::Index>(grid.size);
  const double kept = std::exp(-refractory);
  const double spread = std::max(std::sqrt(1.0 - kept * kept), least_spread * spacing);
  std::array<Eigen::MatrixXd, 2> landing{Eigen::MatrixXd::Zero(n, n), Eigen::MatrixXd::Zero(n, n)};
  for (std::size_t j = 0; j < grid.size; ++j) {
    add_normal(grid, kept * (grid.at(j) + noise.on), spread, 1.0,
               landing[0].row(static_cast<Eigen::Index>(j)));
    add_normal(grid, kept * (grid.at(j) - noise.off), spread, 1.0,
               landing[1].row(static_cast<Eigen::Index>(j)));
  }

  // The interval that begins at each reference, and where the reference is at its end. Fast parts end before leakage
  // moves the reference; the slowest one follows it from level to level.
  std::array<Eigen::MatrixXd, 2> leaves{Eigen::MatrixXd::Zero(n, n), Eigen::MatrixXd::Zero(n, n)};
  std::vector<IntervalsFrom> intervals;
  for (std::size_t j = 0; j < grid.size; ++j) {
    const Passage& p = passages[j];
    const auto row = static_cast<Eigen::Index>(j);
    IntervalsFrom from(edges);
    for (Eigen::Index k = 1; k < p.rates.size(); ++k) {
      const std::array<double, 2> share{p.share(0, k), p.share(1, k)};
      if (std::abs(share[0]) + std::abs(share[1]) < negligible) continue;
      leaves[0](row, row) += share[0];
      leaves[1](row, row) += share[1];
      from.mean += (share[0] + share[1]) / p.rates[k];
      from.add(share, p.rates[k], 0.0, never);
    }
    double left = p.share(0, 0) + p.share(1, 0), begin = 0.0;
    for (std::size_t at = j; left > negligible; --at) {
      const Passage& here = passages[at];
      const double rate = here.rates[0];
      const double both = here.out[0][0] + here.out[1][0];
      const double stay = leak > 0.0 && at > 0 ? (at == j ? 0.5 : 1.0) * spacing / leak : never;
      const double gone = -std::expm1(-rate * stay);
      const std::array<double, 2> share{left * here.out[0][0] / both, left * here.out[1][0] / both};
      leaves[0](row, static_cast<Eigen::Index>(at)) += share[0] * gone;
      leaves[1](row, static_cast<Eigen::Index>(at)) += share[1] * gone;
      from.add(share, rate, begin, begin + stay);
      from.mean += left * gone / rate;
      if (stay >= never) break;
      left *= 1.0 - gone;
      begin += stay;
    }
    intervals.push_back(std::move(from));
  }

  // The references after an event, in the long run.
  const Eigen::MatrixXd after_on = leaves[0] * landing[0], after_off = leaves[1] * landing[1];
  Eigen::MatrixXd chain = (after_on + after_off).transpose();
  chain.diagonal().array() -= 1.0;
  chain.row(0).setOnes();
  Eigen::VectorXd one = Eigen::VectorXd::Zero(n);
  one[0] = 1.0;
  const Eigen::VectorXd references = chain.partialPivLu().solve(one);
  double mean_s = noise.refractory_s;
  for (std::size_t j = 0; j < grid.size; ++j)
    mean_s += references[static_cast<Eigen::Index>(j)] * intervals[j].mean * noise.time_constant_s;

  StillRates rates;
  const std::array<Eigen::VectorXd, 2> begin{after_on.transpose() * references,
                                             after_off.transpose() * references};
  rates.on_hz = begin[0].sum() / mean_s;
  rates.off_hz = begin[1].sum() / mean_s;
  for (const std::size_t first : {0U, 1U}) {
    for (const std::size_t next : {0U, 1U}) {
      std::vector<double>& bins = rates.intervals_hz[2 * first + next];
      bins.assign(edges.size() - 1, 0.0);
      for (std::size_t j = 0; j < grid.size; ++j) {
        for (std::size_t b = 0; b < bins.size(); ++b)
          bins[b] += begin[first][static_cast<Eigen::Index>(j)] * intervals[j].shares[next][b] / mean_s;
      }
    }
  }
  return rates;
}

}  // namespace saccade
