#include "control/bounded_qp.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <limits>

#include "core/random.h"

namespace saccade {
namespace {

template <int N>
struct QpCase {
  Eigen::Matrix<double, N, N> h;
  Eigen::Matrix<double, N, 1> g, lower, upper;
};

/// Least squares of random rank and scale plus damping; bounds of every width, some of them equal.
template <int N>
QpCase<N> random_problem(const RandomStream& random, std::uint64_t i) {
  QpCase<N> p;
  const double damping = std::pow(10.0, random.uniform(-6.0, 0.0, 1000, i));
  const int rows = static_cast<int>(random.uniform(1.0, N + 1.0, 1001, i));
  p.h = damping * Eigen::Matrix<double, N, N>::Identity();
  p.g.setZero();
  std::uint64_t s = 0;
  for (int r = 0; r < rows; ++r) {
    Eigen::Matrix<double, N, 1> row;
    for (int j = 0; j < N; ++j) row[j] = random.normal(s++, i);
    p.h += row * row.transpose();
    p.g += row * random.normal(s++, i) * 3.0;
  }
  for (int j = 0; j < N; ++j) {
    const double middle = random.normal(s++, i);
    const double kind = random.uniform(s++, i);
    const double width = kind < 0.05 ? 0.0 : kind < 0.2 ? 10.0 : random.uniform(0.0, 1.5, s++, i);
    p.lower[j] = middle - width;
    p.upper[j] = middle + width;
  }
  return p;
}

template <int N>
double cost(const QpCase<N>& p, const Eigen::Matrix<double, N, 1>& x) {
  return 0.5 * x.dot(p.h * x) - p.g.dot(x);
}

/// How far x is from the Karush-Kuhn-Tucker conditions, which are necessary and sufficient here.
template <int N>
double kkt_violation(const QpCase<N>& p, const Eigen::Matrix<double, N, 1>& x) {
  const Eigen::Matrix<double, N, 1> gradient = p.h * x - p.g;
  double worst = 0.0;
  for (int j = 0; j < N; ++j) {
    if (x[j] < p.lower[j] || x[j] > p.upper[j]) return std::numeric_limits<double>::infinity();
    double wrong = std::abs(gradient[j]);
    if (x[j] == p.lower[j]) wrong = std::max(0.0, -gradient[j]);
    if (x[j] == p.upper[j]) wrong = x[j] == p.lower[j] ? 0.0 : std::max(0.0, gradient[j]);
    worst = std::max(worst, wrong);
  }
  return worst;
}

/// The lowest cost over all 3^N ways to hold each variable free, at its lower or at its upper bound.
template <int N>
Eigen::Matrix<double, N, 1> best_of_all_active_sets(const QpCase<N>& p) {
  int sets = 1;
  for (int j = 0; j < N; ++j) sets *= 3;
  double best = std::numeric_limits<double>::infinity();
  Eigen::Matrix<double, N, 1> best_x;
  for (int set = 0; set < sets; ++set) {
    Eigen::Matrix<double, N, N> a = p.h;
    Eigen::Matrix<double, N, 1> b = p.g;
    for (int j = 0, code = set; j < N; ++j, code /= 3) {
      if (code % 3 == 0) continue;
      a.row(j).setZero();
      a(j, j) = 1.0;
      b[j] = code % 3 == 1 ? p.lower[j] : p.upper[j];
    }
    const Eigen::Matrix<double, N, 1> x = a.partialPivLu().solve(b);
    constexpr double rounding = 1e-9;
    if (((x - p.lower).array() < -rounding).any() || ((p.upper - x).array() < -rounding).any()) continue;
    if (cost<N>(p, x) < best) {
      best = cost<N>(p, x);
      best_x = x;
    }
  }
  return best_x;
}

TEST(BoundedQp, FindsTheOptimumOfTwentyThousandRandomProblems) {
  const RandomStream random(1, "qp");
  double worst = 0.0;
  int most_iterations = 0;
  long iterations = 0;
  int bound = 0;
  BoundedQp<6> qp;  // one solver for all: every start is warm, and wrong
  for (std::uint64_t i = 0; i < 20000; ++i) {
    const QpCase<6> p = random_problem<6>(random, i);
    const auto solution = qp.solve(p.h, p.g, p.lower, p.upper);
    ASSERT_TRUE(solution.optimal) << i;
    worst = std::max(worst, kkt_violation<6>(p, solution.x));
    most_iterations = std::max(most_iterations, solution.iterations);
    iterations += solution.iterations;
    bound += ((solution.x.array() == p.lower.array()) || (solution.x.array() == p.upper.array())).any();
  }
  EXPECT_LT(worst, 1e-11);
  EXPECT_GT(bound, 15000);  // else the bounds were never tried
  std::printf("KKT violation %.2g, iterations: mean %.2f, most %d\n", worst,
              static_cast<double>(iterations) / 20000.0, most_iterations);
}

TEST(BoundedQp, AgreesWithTheBestOfAllActiveSets) {
  const RandomStream random(2, "qp");
  BoundedQp<4> qp;
  for (std::uint64_t i = 0; i < 20000; ++i) {
    const QpCase<4> p = random_problem<4>(random, i);
    const auto x = qp.solve(p.h, p.g, p.lower, p.upper).x;
    const Eigen::Vector4d best = best_of_all_active_sets<4>(p);
    // Strictly convex: costs that differ by d hold points within sqrt(2 d / damping) of each other.
    ASSERT_NEAR(cost<4>(p, x), cost<4>(p, best), 1e-7 * (1.0 + std::abs(cost<4>(p, best)))) << i;
  }
}

TEST(BoundedQp, SolvesEverySizeItIsMadeFor) {
  const RandomStream random(3, "qp");
  const auto check = [&]<int N>(std::integral_constant<int, N>) {
    BoundedQp<N> qp;
    for (std::uint64_t i = 0; i < 2000; ++i) {
      const QpCase<N> p = random_problem<N>(random, i);
      const auto solution = qp.solve(p.h, p.g, p.lower, p.upper);
      ASSERT_TRUE(solution.optimal);
      ASSERT_LT(kkt_violation<N>(p, solution.x), 1e-11);
    }
  };
  check(std::integral_constant<int, 1>{});
  check(std::integral_constant<int, 2>{});
  check(std::integral_constant<int, 3>{});
  check(std::integral_constant<int, 8>{});
}

TEST(BoundedQp, AWarmStartAtTheOptimumNeedsOneIteration) {
  const RandomStream random(4, "qp");
  for (std::uint64_t i = 0; i < 1000; ++i) {
    const QpCase<6> p = random_problem<6>(random, i);
    BoundedQp<6> qp;
    const auto first = qp.solve(p.h, p.g, p.lower, p.upper);
    const auto again = qp.solve(p.h, p.g, p.lower, p.upper);
    EXPECT_EQ(again.iterations, 1);
    EXPECT_LT((again.x - first.x).norm(), 1e-6);
  }
}

TEST(BoundedQpDeathTest, CrossedBoundsBreakItsPromise) {
  BoundedQp<1> qp;
  using Scalar = Eigen::Matrix<double, 1, 1>;
  EXPECT_DEATH((void)qp.solve(Scalar(1.0), Scalar(0.0), Scalar(1.0), Scalar(-1.0)), "broken invariant");
}

}  // namespace
}  // namespace saccade
