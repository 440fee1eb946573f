#pragma once

#include <Eigen/Core>

namespace saccade {

/// Solvers for small dense systems that neither allocate nor throw.
///
/// Each does the operations of the solver of Eigen 3.4 that it names, in the same order, so that results agree bit for
/// bit. Eigen's own solvers instantiate its blocked matrix products, which takes seconds in each file that uses one.

/// Solves A x = b for a symmetric positive definite A of n <= 12 rows, by Cholesky factorisation (Eigen::LLT). `a`: A by
/// columns, of which the lower triangle is read; it is overwritten. `b`: b on entry, x on return. Where A is not
/// positive definite x has no meaning.
void solve_cholesky(double* a, double* b, int n);

template <int N>
[[nodiscard]] Eigen::Matrix<double, N, 1> cholesky_solution(Eigen::Matrix<double, N, N> a,
                                                            Eigen::Matrix<double, N, 1> b) {
  static_assert(N >= 1 && N <= 12);
  solve_cholesky(a.data(), b.data(), N);
  return b;
}

/// The same by the factorisation L D L' with pivoting (Eigen::LDLT), for A positive or negative semidefinite.
[[nodiscard]] Eigen::Vector3d ldlt_solution(const Eigen::Matrix3d& a, const Eigen::Vector3d& b);

/// The x of least norm among those that minimise |A x - b|, whatever the rank of A
/// (Eigen::CompleteOrthogonalDecomposition).
[[nodiscard]] Eigen::Vector3d least_norm_solution(const Eigen::Matrix3d& a, const Eigen::Vector3d& b);
[[nodiscard]] Eigen::Vector2d least_norm_solution(const Eigen::Matrix<double, 3, 2>& a,
                                                  const Eigen::Vector3d& b);

}  // namespace saccade
