#include "core/small_solve.h"

#include <gtest/gtest.h>

#include "core/random.h"

namespace saccade {
namespace {

/// A matrix of normally distributed numbers, the same for the same `stream`.
template <int Rows, int Columns>
Eigen::Matrix<double, Rows, Columns> random_matrix(std::uint64_t stream) {
  const RandomStream random(3, "small_solve_test");
  Eigen::Matrix<double, Rows, Columns> m;
  for (int i = 0; i < m.size(); ++i) m.data()[i] = random.normal(stream, static_cast<std::uint64_t>(i));
  return m;
}

template <int N>
Eigen::Matrix<double, N, N> positive_definite(std::uint64_t stream) {
  const auto m = random_matrix<N, N>(stream);
  return m.transpose() * m + 0.1 * Eigen::Matrix<double, N, N>::Identity();
}

template <int N>
void expect_cholesky_solves() {
  for (std::uint64_t i = 0; i < 100; ++i) {
    const auto a = positive_definite<N>(2 * i);
    const auto b = random_matrix<N, 1>(2 * i + 1);
    EXPECT_LT((a * cholesky_solution<N>(a, b) - b).norm(), 1e-12 * a.norm())
        << N << " unknowns, system " << i;
  }
}

TEST(SmallSolve, CholeskySolvesPositiveDefiniteSystemsOfEverySize) {
  expect_cholesky_solves<3>();
  expect_cholesky_solves<6>();
  expect_cholesky_solves<12>();
}

TEST(SmallSolve, LdltSolvesDefiniteSystemsOfEitherSign) {
  for (std::uint64_t i = 0; i < 100; ++i) {
    const Eigen::Matrix3d a = (i % 2 == 0 ? 1.0 : -1.0) * positive_definite<3>(2 * i);
    const Eigen::Vector3d b = random_matrix<3, 1>(2 * i + 1);
    EXPECT_LT((a * ldlt_solution(a, b) - b).norm(), 1e-12 * a.norm());
  }
}

TEST(SmallSolve, LdltReturnsZeroForTheZeroMatrix) {
  EXPECT_EQ(ldlt_solution(Eigen::Matrix3d::Zero(), Eigen::Vector3d::Ones()), Eigen::Vector3d::Zero());
}

/// The conditions that the pseudo-inverse fulfils: the residual is orthogonal to the columns of A, and x to its null
/// space, which is orthogonal to the rows.
template <int Columns>
void expect_least_norm(const Eigen::Matrix<double, 3, Columns>& a, const Eigen::Vector3d& b) {
  const Eigen::Matrix<double, Columns, 1> x = least_norm_solution(a, b);
  EXPECT_LT((a.transpose() * (a * x - b)).norm(), 1e-12 * (1.0 + a.squaredNorm())) << a;
  const Eigen::Matrix<double, Columns, 1> other = least_norm_solution(a, Eigen::Vector3d(a * x));
  EXPECT_LT((other - x).norm(), 1e-10 * (1.0 + x.norm())) << a;
}

TEST(SmallSolve, FindsTheLeastSquaresSolutionOfFullRank) {
  for (std::uint64_t i = 0; i < 100; ++i) {
    expect_least_norm<3>(random_matrix<3, 3>(2 * i), random_matrix<3, 1>(2 * i + 1));
    expect_least_norm<2>(random_matrix<3, 2>(2 * i), random_matrix<3, 1>(2 * i + 1));
  }
}

TEST(SmallSolve, FindsTheSolutionOfLeastNormWhereColumnsDependOnEachOther) {
  for (std::uint64_t i = 0; i < 100; ++i) {
    Eigen::Matrix3d a = random_matrix<3, 3>(2 * i);
    const Eigen::Vector3d b = random_matrix<3, 1>(2 * i + 1);
    a.col(2) = a.col(0) + 2.0 * a.col(1);  // null space (1, 2, -1)
    expect_least_norm<3>(a, b);
    EXPECT_NEAR(least_norm_solution(a, b).dot(Eigen::Vector3d(1, 2, -1)), 0.0, 1e-9);
    a.col(1) = 3.0 * a.col(0);  // null space: all orthogonal to (1, 3, 7)
    a.col(2) = 7.0 * a.col(0);
    expect_least_norm<3>(a, b);
    EXPECT_LT(least_norm_solution(a, b).cross(Eigen::Vector3d(1, 3, 7)).norm(), 1e-9);
  }
  EXPECT_EQ(least_norm_solution(Eigen::Matrix3d(Eigen::Matrix3d::Zero()), Eigen::Vector3d(1, 2, 3)),
            Eigen::Vector3d::Zero());
}

}  // namespace
}  // namespace saccade
