#include "core/small_solve.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>

namespace saccade {

namespace {

/// For a size that the compiler knows: Eigen's order of operations, and so the last bit, depends on that.
template <int N>
void solve_fixed(double* a, double* b) {
  using Matrix = Eigen::Matrix<double, N, N>;
  using Vector = Eigen::Matrix<double, N, 1>;
  const Vector x =
      Eigen::LLT<Matrix>(Matrix(Eigen::Map<const Matrix>(a))).solve(Vector(Eigen::Map<const Vector>(b)));
  Eigen::Map<Vector>{b} = x;
}

template <int N>
void solve_of_size(double* a, double* b, int n) {
  if (n == N) return solve_fixed<N>(a, b);
  if constexpr (N > 1) solve_of_size<N - 1>(a, b, n);
}

}  // namespace

void solve_cholesky(double* a, double* b, int n) { solve_of_size<12>(a, b, n); }

Eigen::Vector3d ldlt_solution(const Eigen::Matrix3d& a, const Eigen::Vector3d& b) {
  return a.ldlt().solve(b);
}

Eigen::Vector3d least_norm_solution(const Eigen::Matrix3d& a, const Eigen::Vector3d& b) {
  return a.completeOrthogonalDecomposition().solve(b);
}

Eigen::Vector2d least_norm_solution(const Eigen::Matrix<double, 3, 2>& a, const Eigen::Vector3d& b) {
  return a.completeOrthogonalDecomposition().solve(b);
}

}  // namespace saccade
