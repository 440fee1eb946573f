#include "control/bounded_qp.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <limits>

#include "core/random.h"

namespace saccade {
namespace {

/// Of dynamic size, so that only the solver itself is compiled for every size.
struct QpCase {
  Eigen::MatrixXd h;
  Eigen::VectorXd g, lower, upper;
};

/// Least squares of random rank and scale plus damping; bounds of every width, some of them equal.
QpCase random_problem(int n, const RandomStream& random, std::uint64_t i) {
  QpCase p;
  const double damping = std::pow(10.0, random.uniform(-6.0, 0.0, 1000, i));
  const int rows = static_cast<int>(random.uniform(1.0, n + 1.0, 1001, i));
  p.h = damping * Eigen::MatrixXd::Identity(n, n);
  p.g = p.lower = p.upper = Eigen::VectorXd::Zero(n);
  std::uint64_t s = 0;
  for (int r = 0; r < rows; ++r) {
    Eigen::VectorXd row(n);
    for (int j = 0; j < n; ++j) row[j] = random.normal(s++, i);
    p.h += row * row.transpose();
    p.g += row * random.normal(s++, i) * 3.0;
  }
  for (int j = 0; j < n; ++j) {
    const double middle = random.normal(s++, i);
    const double kind = random.uniform(s++, i);
    const double width = kind < 0.05 ? 0.0 : kind < 0.2 ? 10.0 : random.uniform(0.0, 1.5, s++, i);
    p.lower[j] = middle - width;
    p.upper[j] = middle + width;
  }
  return p;
}

double cost(const QpCase& p, const Eigen::VectorXd& x) { return 0.5 * x.dot(p.h * x) - p.g.dot(x); }

/// How far x is from the Karush-Kuhn-Tucker conditions, which are necessary and sufficient here.
double kkt_violation(const QpCase& p, const Eigen::VectorXd& x) {
  const Eigen::VectorXd gradient = p.h * x - p.g;
  double worst = 0.0;
  for (Eigen::Index j = 0; j < x.size(); ++j) {
    if (x[j] < p.lower[j] || x[j] > p.upper[j]) return std::numeric_limits<double>::infinity();
    double wrong = std::abs(gradient[j]);
    if (x[j] == p.lower[j]) wrong = std::max(0.0, -gradient[j]);
    if (x[j] == p.upper[j]) wrong = x[j] == p.lower[j] ? 0.0 : std::max(0.0, gradient[j]);
    worst = std::max(worst, wrong);
  }
  return worst;
}

/// The lowest cost over all 3^n ways to hold each variable free, at its lower or at its upper bound.
Eigen::VectorXd best_of_all_active_sets(const QpCase& p) {
  const int n = static_cast<int>(p.g.size());
  int sets = 1;
  for (int j = 0; j < n; ++j) sets *= 3;
  double best = std::numeric_limits<double>::infinity();
  Eigen::VectorXd best_x;
  for (int set = 0; set < sets; ++set) {
    Eigen::MatrixXd a = p.h;
    Eigen::VectorXd b = p.g;
    for (int j = 0, code = set; j < n; ++j, code /= 3) {
      if (code % 3 == 0) continue;
      a.row(j).setZero();
      a(j, j) = 1.0;
      b[j] = code % 3 == 1 ? p.lower[j] : p.upper[j];
    }
    const Eigen::VectorXd x = a.partialPivLu().solve(b);
    constexpr double rounding = 1e-9;
    if (((x - p.lower).array() < -rounding).any() || ((p.upper - x).array() < -rounding).any()) continue;
    if (cost(p, x) < best) {
      best = cost(p, x);
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
    const QpCase p = random_problem(6, random, i);
    const auto solution = qp.solve(p.h, p.g, p.lower, p.upper);
    ASSERT_TRUE(solution.optimal) << i;
    worst = std::max(worst, kkt_violation(p, solution.x));
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
  BoundedQp<3> qp;
  for (std::uint64_t i = 0; i < 20000; ++i) {
    const QpCase p = random_problem(3, random, i);
    const auto x = qp.solve(p.h, p.g, p.lower, p.upper).x;
    const Eigen::VectorXd best = best_of_all_active_sets(p);
    // Strictly convex: costs that differ by d hold points within sqrt(2 d / damping) of each other.
    ASSERT_NEAR(cost(p, x), cost(p, best), 1e-7 * (1.0 + std::abs(cost(p, best)))) << i;
  }
}

TEST(BoundedQp, SolvesTheSizeOfTheNeckProblem) {
  const RandomStream random(3, "qp");
  BoundedQp<3> qp;
  for (std::uint64_t i = 0; i < 2000; ++i) {
    const QpCase p = random_problem(3, random, i);
    const auto solution = qp.solve(p.h, p.g, p.lower, p.upper);
    ASSERT_TRUE(solution.optimal);
    ASSERT_LT(kkt_violation(p, solution.x), 1e-11);
  }
}

TEST(BoundedQp, AWarmStartAtTheOptimumNeedsOneIteration) {
  const RandomStream random(4, "qp");
  for (std::uint64_t i = 0; i < 1000; ++i) {
    const QpCase p = random_problem(6, random, i);
    BoundedQp<6> qp;
    const auto first = qp.solve(p.h, p.g, p.lower, p.upper);
    const auto again = qp.solve(p.h, p.g, p.lower, p.upper);
    EXPECT_EQ(again.iterations, 1);
    EXPECT_LT((again.x - first.x).norm(), 1e-6);
  }
}

TEST(BoundedQpDeathTest, CrossedBoundsAbort) {
  BoundedQp<3> qp;
  const Eigen::Vector3d one = Eigen::Vector3d::Ones();
  EXPECT_DEATH((void)qp.solve(Eigen::Matrix3d::Identity(), one, one, -one), "broken invariant");
}

}  // namespace
}  // namespace saccade
