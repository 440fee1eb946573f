#pragma once

#include <Eigen/Core>

namespace saccade {

/// Eigen's solvers for small dense systems, in one file: they instantiate its blocked matrix products, which takes seconds of
/// compilation in each file that uses one. They neither allocate nor throw.

/// Solves A x = b for a symmetric positive definite A, of which the lower triangle is read, by Cholesky factorisation
/// (Eigen::LLT). Where A is not positive definite x has no meaning. N: the sizes of the gaze controllers, 3, 6 and 12.
template <int N>
[[nodiscard]] Eigen::Matrix<double, N, 1> cholesky_solution(const Eigen::Matrix<double, N, N>& a,
                                                            const Eigen::Matrix<double, N, 1>& b);

/// The same by the factorisation L D L' with pivoting (Eigen::LDLT), for A positive or negative semidefinite.
[[nodiscard]] Eigen::Vector3d ldlt_solution(const Eigen::Matrix3d& a, const Eigen::Vector3d& b);

/// The x of least norm among those that minimise |A x - b|, whatever the rank of A
/// (Eigen::CompleteOrthogonalDecomposition).
[[nodiscard]] Eigen::Vector3d least_norm_solution(const Eigen::Matrix3d& a, const Eigen::Vector3d& b);
[[nodiscard]] Eigen::Vector2d least_norm_solution(const Eigen::Matrix<double, 3, 2>& a,
                                                  const Eigen::Vector3d& b);

}  // namespace saccade
